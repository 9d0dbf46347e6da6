#pragma once

#include <dn/eigen_alignment.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace dn {

/// Small-scale relief of natural ground as a height over east and north, with zero mean. It is
/// noise on square lattices of 8, 4, 2 and 1 m, interpolated smoothly between the lattice points.
/// The amplitude is proportional to the lattice spacing to the power of 0.8 (a surface of fractal
/// dimension 2.2).
class Roughness {
 public:
  /// rms_m: root mean square of the height; 0: no relief.
  Roughness(double rms_m, std::uint64_t seed);

  /// Returns the height at a point, m.
  double At(const Eigen::Vector2d& en_m) const;

  /// Upper bounds of |height| (m) and of the slope in any direction.
  double bound_m() const;
  double slope_bound() const;

 private:
  static constexpr int kOctaves = 4;
  std::array<double, kOctaves> amplitude_m_{};
  std::uint64_t seed_;
};

}  // namespace dn
