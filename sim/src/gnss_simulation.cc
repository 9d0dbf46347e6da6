#include "gnss_simulation.h"

#include <dn/sim/random.h>

#include <cmath>

namespace dn {

GnssData SimulateGnss(const GnssScenario& gnss, const Eigen::Vector3d& lever_arm_b_m,
                      const TruthTrajectory& truth, std::uint64_t seed, double noise_scale) {
  Random random(seed, "gnss");
  const Eigen::Matrix3d position_covariance = gnss.sigma_enu_m.cwiseAbs2().asDiagonal();
  const Eigen::Matrix3d velocity_covariance = kGnssVelocitySigma_enu_mps.cwiseAbs2().asDiagonal();
  GnssData data;
  long line = 0;  // of GPS.txt
  const auto first = static_cast<long>(std::ceil(truth.t_begin_s() * gnss.rate_hz));
  for (long k = first; static_cast<double>(k) / gnss.rate_hz <= truth.t_end_s(); ++k) {
    const double t_s = static_cast<double>(k) / gnss.rate_hz;
    const TruthState state = truth.State(t_s);
    const Eigen::Matrix3d R_mb = state.pose.q_mb.toRotationMatrix();
    const Eigen::Vector3d antenna_m = state.pose.p_mb + R_mb * lever_arm_b_m;
    const Eigen::Matrix3d R_m_enu = truth.frame().R_m_enu(antenna_m);
    const Eigen::Vector3d error_enu = noise_scale * gnss.sigma_enu_m.cwiseProduct(random.Normal3());
    GnssEpoch epoch;
    epoch.t_s = t_s;
    epoch.line = ++line;
    epoch.antenna = truth.frame().ToGeodetic(antenna_m + R_m_enu * error_enu);
    epoch.covariance_enu_m2 = position_covariance;
    if (gnss.velocity) {
      const Eigen::Vector3d v_m = state.pose.v_m + R_mb * state.w_mb_b.cross(lever_arm_b_m);
      epoch.velocity_enu_mps =
          R_m_enu.transpose() * v_m +
          noise_scale * kGnssVelocitySigma_enu_mps.cwiseProduct(random.Normal3());
      epoch.velocity_covariance_enu = velocity_covariance;
    }
    data.epochs.push_back(epoch);
  }
  return data;
}

}  // namespace dn
