#include <dn/error.h>
#include <dn/factors/gnss_velocity.h>
#include <dn/rotation.h>

namespace dn {

GnssVelocity::GnssVelocity(const Eigen::Vector3d& z_m, const Eigen::Vector3d& w_ib_b_radps,
                           const Eigen::Vector3d& w_ie_m_radps, const Noise<3>& noise)
    : z_m_(z_m), w_ib_b_(w_ib_b_radps), w_ie_m_(w_ie_m_radps), W_(noise.sqrt_information()) {
  if (!z_m.allFinite()) throw InvalidInput("GNSS velocity is not finite");
  if (!w_ib_b_radps.allFinite()) throw InvalidInput("angular rate of the body is not finite");
  if (!w_ie_m_radps.allFinite()) throw InvalidInput("angular rate of the Earth is not finite");
}

bool GnssVelocity::Evaluate(double const* const* x, double* r, double** J) const {
  const Eigen::Matrix3d R_mb = Eigen::Map<const Eigen::Quaterniond>(x[0]).toRotationMatrix();
  const Eigen::Vector3d a_b(x[2]);
  const Eigen::Vector3d w_eb_b = w_ib_b_ - R_mb.transpose() * w_ie_m_;

  // R_mb (w_eb_b x a_b) = R_mb (w_ib_b x a_b) - w_ie_m x (R_mb a_b). In the second term w_ie_m is
  // in map axes, so only a_b is rotated.
  const Eigen::Vector3d w_ib_x_a_b = w_ib_b_.cross(a_b);
  Put<0>(x, J, W_ * (Skew(w_ie_m_) * R_mb * Skew(a_b) - R_mb * Skew(w_ib_x_a_b)));
  Put<1>(x, J, W_);
  Put<2>(x, J, W_ * R_mb * Skew(w_eb_b));
  return Residual(x[0], x[1], x[2], r);
}

}  // namespace dn
