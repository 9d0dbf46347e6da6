#pragma once

#include <dn/geo/trajectory.h>

#include <vector>

namespace dn {

/// Interpolates poses between the epochs of a trajectory.
///
/// Position: cubic Hermite from positions and velocities (InterpolatePose). Attitude: with q_k of
/// the epoch before t,
///
///   q(t) = q_k Exp( sum_m l_m(t) Log(q_k^-1 q_m) ),      m = k-1, k, k+1, k+2,
///
/// where l_m are the Lagrange polynomials on the four epochs. Rotation vectors have no singular
/// attitude and no wrap of heading. A neighbour is not used if it is missing or further away than
/// three times the present step. The degree of the polynomial is then one or two lower.
///
/// An oscillation in attitude has amplitude a and frequency f and is sampled at f_s. The error in
/// the middle of a step is then 0.0234 (2 pi f / f_s)^4 a. With a linear interpolation it is 0.125
/// (2 pi f / f_s)^2 a. With 1 Hz of motion, at 10 Hz: 0.4 % of the amplitude instead of 5 %; at 200
/// Hz: 2e-8.
class PoseInterpolator {
 public:
  enum class Method {
    kCubic,   ///< as above
    kLinear,  ///< linear in position, spherical linear in attitude
  };

  /// Takes the poses in increasing time; throws InvalidInput if there are fewer than two.
  explicit PoseInterpolator(std::vector<MapPose> poses);

  /// Returns the pose at t_s. Throws InvalidInput with the time and the span if t_s is outside.
  MapPose At(double t_s, Method method = Method::kCubic) const;
  /// Returns the pose at t_s, or at the nearer end if t_s is outside.
  MapPose Nearest(double t_s) const;

 private:
  Eigen::Quaterniond AttitudeAt(std::size_t k, double t_s) const;

  std::vector<MapPose> poses_;
};

}  // namespace dn
