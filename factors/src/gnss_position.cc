#include <dn/error.h>
#include <dn/factors/gnss_position.h>
#include <dn/rotation.h>

namespace dn {

GnssPosition::GnssPosition(const Eigen::Vector3d& z_m, const Noise<3>& noise)
    : z_m_(z_m), W_(noise.sqrt_information()) {
  if (!z_m.allFinite()) throw InvalidInput("GNSS position is not finite");
}

bool GnssPosition::Evaluate(double const* const* x, double* r, double** J) const {
  const Eigen::Matrix3d R_mb = Eigen::Map<const Eigen::Quaterniond>(x[0]).toRotationMatrix();
  const Eigen::Vector3d a_b(x[2]);

  Put<0>(x, J, -W_ * R_mb * Skew(a_b));
  Put<1>(x, J, W_);
  Put<2>(x, J, W_ * R_mb);
  return Residual(x[0], x[1], x[2], r);
}

}  // namespace dn
