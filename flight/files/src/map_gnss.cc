#include <dn/files/map_gnss.h>

namespace dn {

MapGnss ToMap(const GnssData& gnss, const LocalFrame& frame) {
  MapGnss out;
  out.epochs.reserve(gnss.epochs.size());
  for (const GnssEpoch& epoch : gnss.epochs) {
    const Eigen::Vector3d p_m = frame.ToMap(epoch.antenna);
    out.epochs.push_back({epoch.t_s, p_m, frame.R_m_enu(p_m), epoch.covariance_enu_m2,
                          epoch.velocity_enu_mps, epoch.velocity_covariance_enu, epoch.line});
  }
  return out;
}

}  // namespace dn
