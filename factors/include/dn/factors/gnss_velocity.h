#pragma once

#include <dn/block.h>
#include <dn/factor.h>
#include <dn/noise.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace dn {

/// GNSS antenna velocity with respect to the Earth in the map frame m, with the lever arm
/// estimated.
///
///   r = W (v_m + R_mb (w_eb_b x a_b) - z_m),   w_eb_b = w_ib_b - R_mb^T w_ie_m     [3], unitless
///
///   block | symbol | stored | tangent | meaning
///   ------|--------|--------|---------|------------------------------------------
///     0   | q_mb   |   4    |    3    | rotation body -> map, (x, y, z, w)
///     1   | v_m    |   3    |    3    | velocity of the body origin in map, m/s
///     2   | a_b    |   3    |    3    | antenna phase centre in body, m
///
/// Jacobians (tangent of block 0: right, rad):
///   W (-R_mb [w_ib_b x a_b]x + [w_ie_m]x R_mb [a_b]x),  W,  W R_mb [w_eb_b]x.
/// Degenerate when: the body does not rotate (a_b is then unobservable); |a_b| = 0 gives no
/// information on attitude. The angular rate is treated as known: `noise` must include its error
/// times |a_b|.
class GnssVelocity final : public Factor<GnssVelocity, 3, Rotation, Vec<3>, Vec<3>> {
 public:
  /// Creates the factor. z_m is the measured antenna velocity in map, m/s. w_ib_b_radps is the
  /// bias-corrected angular rate at the epoch, and w_ie_m_radps the Earth rotation in map. `noise`
  /// is in map axes, m/s. Throws InvalidInput if a value is not finite.
  GnssVelocity(const Eigen::Vector3d& z_m, const Eigen::Vector3d& w_ib_b_radps,
               const Eigen::Vector3d& w_ie_m_radps, const Noise<3>& noise);

  template <class T>
  bool Residual(const T* q_mb_data, const T* v_m_data, const T* a_b_data, T* r_data) const {
    using Vec3 = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Eigen::Quaternion<T>> q_mb(q_mb_data);
    const Eigen::Map<const Vec3> v_m(v_m_data), a_b(a_b_data);
    const Vec3 w_eb_b = w_ib_b_.cast<T>() - q_mb.conjugate() * w_ie_m_.cast<T>();
    Eigen::Map<Vec3> r(r_data);
    r = W_.cast<T>() * (v_m + q_mb * w_eb_b.cross(a_b) - z_m_.cast<T>());
    return true;
  }

  bool Evaluate(double const* const* x, double* r, double** J) const override;

 private:
  Eigen::Vector3d z_m_;
  Eigen::Vector3d w_ib_b_;
  Eigen::Vector3d w_ie_m_;
  Eigen::Matrix3d W_;
};

}  // namespace dn
