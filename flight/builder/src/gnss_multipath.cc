#include <dn/builder/gnss_multipath.h>

#include <cmath>

namespace dn {

Eigen::Vector3d GnssProcessSigma(const GnssProcess& process, const MapPose& pose,
                                 const Eigen::Vector3d& up_m) {
  if (process.growth == GnssErrorGrowth::kNone) return process.sigma_enu_m;
  const Eigen::Vector3d up_b = pose.q_mb.conjugate() * up_m;
  const double bank_rad = std::atan2(std::abs(up_b.y()), -up_b.z());
  return bank_rad / kReferenceBankRad * process.sigma_enu_m;
}

}  // namespace dn
