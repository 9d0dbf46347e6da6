#pragma once

#include <dn/eigen_alignment.h>

#include <Eigen/Core>
#include <cstdint>
#include <random>
#include <string_view>

namespace dn {

/// Mixes 64 bits (splitmix64), so that neighbouring inputs give unrelated outputs.
std::uint64_t MixBits(std::uint64_t x);

/// Seeded random numbers. Streams with different names are independent: additional draws from one
/// stream do not change the others.
class Random {
 public:
  Random(std::uint64_t seed, std::string_view stream);

  /// Returns a uniform number in [0, 1).
  double Uniform() { return static_cast<double>(engine_() >> 11) * 0x1.0p-53; }
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }
  double Normal();  ///< returns a standard normal number
  Eigen::Vector3d Normal3() {
    const double x = Normal(), y = Normal(), z = Normal();
    return {x, y, z};
  }

 private:
  std::mt19937_64 engine_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace dn
