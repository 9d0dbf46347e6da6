#include "median_sigmas.h"

#include <dn/median.h>

#include <cmath>
#include <vector>

namespace dn::diagnosis_internal {

Eigen::Vector3d MedianGnssSigma(const Flight& flight) {
  const GnssConfig& config = *flight.config.gnss;
  Eigen::Vector3d sigma_enu_m = config.sigma_enu_m;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> sigmas_m;
    for (const MapGnssEpoch& epoch : flight.gnss->epochs) {
      sigmas_m.push_back(epoch.covariance_enu_m2 ? std::sqrt((*epoch.covariance_enu_m2)(axis, axis))
                                                 : config.sigma_enu_m[axis]);
    }
    if (!sigmas_m.empty()) sigma_enu_m[axis] = Median(sigmas_m);
  }
  return config.sigma_scale * sigma_enu_m;
}

double MedianPairSigma(const Flight& flight) {
  std::vector<double> sigma_m;
  for (const LidarPair& pair : flight.pairs->pairs) {
    if (pair.covariance_m2) sigma_m.push_back(std::sqrt(pair.covariance_m2->trace() / 3.0));
  }
  return 2 * sigma_m.size() > flight.pairs->pairs.size() ? Median(sigma_m)
                                                         : flight.config.lidar->sigma_p_m;
}

}  // namespace dn::diagnosis_internal
