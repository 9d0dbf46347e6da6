#pragma once

#include <dn/block.h>
#include <dn/factor.h>
#include <dn/noise.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace dn {

/// GNSS antenna position in the map frame m, with its lever arm estimated.
///
///   r = W (p_mb + R_mb a_b - z_m)                                   [3], unitless
///
///   block | symbol | stored | tangent | meaning
///   ------|--------|--------|---------|------------------------------------------
///     0   | q_mb   |   4    |    3    | rotation body -> map, (x, y, z, w)
///     1   | p_mb   |   3    |    3    | body origin in map, m
///     2   | a_b    |   3    |    3    | antenna phase centre in body, m
///
/// Jacobians (tangent of block 0: right, rad):  -W R_mb [a_b]x,  W,  W R_mb.
/// Degenerate when: attitude is constant over the network (a_b and p_mb are then not separable);
/// |a_b| = 0 gives no information on attitude.
class GnssPosition final : public Factor<GnssPosition, 3, Rotation, Vec<3>, Vec<3>> {
 public:
  /// Creates the factor; z_m is the measured antenna position in map, m, and `noise` is in map
  /// axes, m. Throws InvalidInput if z_m is not finite.
  GnssPosition(const Eigen::Vector3d& z_m, const Noise<3>& noise);

  template <class T>
  bool Residual(const T* q_mb_data, const T* p_mb_data, const T* a_b_data, T* r_data) const {
    using Vec3 = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Eigen::Quaternion<T>> q_mb(q_mb_data);
    const Eigen::Map<const Vec3> p_mb(p_mb_data), a_b(a_b_data);
    Eigen::Map<Vec3> r(r_data);
    r = W_.cast<T>() * (p_mb + q_mb * a_b - z_m_.cast<T>());
    return true;
  }

  bool Evaluate(double const* const* x, double* r, double** J) const override;

 private:
  Eigen::Vector3d z_m_;
  Eigen::Matrix3d W_;
};

}  // namespace dn
