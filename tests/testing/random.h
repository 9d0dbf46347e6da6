#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <random>

namespace dn::testing {

/// Returns N independent numbers, each uniform in [-scale, scale].
template <int N = 3, class Rng>
Eigen::Matrix<double, N, 1> RandomVector(Rng& rng, double scale) {
  std::uniform_real_distribution<double> uniform(-scale, scale);
  Eigen::Matrix<double, N, 1> v;
  for (int i = 0; i < N; ++i) v[i] = uniform(rng);
  return v;
}

/// Returns a unit quaternion, uniform over all rotations.
template <class Rng>
Eigen::Quaterniond RandomRotation(Rng& rng) {
  std::normal_distribution<double> normal;
  Eigen::Vector4d c;
  do {
    for (int i = 0; i < 4; ++i) c[i] = normal(rng);
  } while (c.norm() < 1e-3);
  return Eigen::Quaterniond(c.normalized());
}

}  // namespace dn::testing
