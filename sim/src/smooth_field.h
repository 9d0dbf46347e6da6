#pragma once

#include <dn/sim/random.h>

#include <Eigen/Core>
#include <array>
#include <vector>

namespace dn {

/// A random vector that varies smoothly over the ground: three independent, stationary fields with
/// variance 1 and correlation exp(-d^2 / (2 length^2)) at distance d.
///
/// Source: Rahimi & Recht, Random features for large-scale kernel machines, NIPS 2007.
class SmoothField {
 public:
  SmoothField(double length_m, Random* random);

  Eigen::Vector3d At(const Eigen::Vector2d& en_m) const;

 private:
  struct Wave {
    Eigen::Vector2d radpm;  // wave vector
    double phase_rad;
  };
  std::array<std::vector<Wave>, 3> waves_;  // by axis
};

}  // namespace dn
