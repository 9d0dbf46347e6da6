// IMU and GNSS: the smoothed trajectory of a simulated survey flight, in memory.
//
// Prints errors and standard deviations of position and attitude at a few epochs. The rms of the
// normalised errors, also printed, is 1 if the sigmas are correct.
#include <dn/diagnosis/solution.h>
#include <dn/sim/simulate.h>

#include <cmath>
#include <cstdio>

int main() {
  dn::Scenario scenario = dn::ReadScenario("lar2");
  scenario.plan.warm_up_s = 60.0;
  scenario.imu.rate_hz = 100.0;
  scenario.pairs.count = 0;
  const dn::SimulatedFlight sim = dn::Simulate(scenario, {});

  dn::AdjustOptions options;
  options.with_pairs = false;
  const dn::Solution solution(sim.flight, options);
  const dn::TrajectoryResult& result = solution.trajectory();

  std::printf("   t [s]   error E, N, U [mm] (sigma)      roll, pitch, heading [mdeg] (sigma)\n");
  double sum2 = 0.0;
  for (std::size_t k = 0; k < result.sigma.size(); ++k) {
    const dn::MapPose pose = solution.network().trajectory().NodePose(k),
                      truth = sim.truth->Pose(pose.t_s);
    const Eigen::Vector3d dp = sim.frame.R_m_enu(truth.p_mb).transpose() * (pose.p_mb - truth.p_mb);
    Eigen::Vector3d da = dn::RollPitchHeading(dn::ToNavPoint(pose, sim.frame).q_nb) -
                         dn::RollPitchHeading(dn::ToNavPoint(truth, sim.frame).q_nb);
    da.z() = std::remainder(da.z(), 360.0 * dn::kRadPerDeg);
    const Eigen::Vector3d sp = result.sigma[k].position_enu_m, sa = result.sigma[k].rph_rad;
    sum2 += dp.cwiseQuotient(sp).squaredNorm() + da.cwiseQuotient(sa).squaredNorm();
    if (k % 60 != 30) continue;
    std::printf("%8.0f", pose.t_s);
    for (int i = 0; i < 3; ++i) std::printf("  %5.1f (%3.1f)", 1e3 * dp[i], 1e3 * sp[i]);
    for (int i = 0; i < 3; ++i)
      std::printf("  %6.2f (%4.2f)", 1e3 * dn::kDegPerRad * da[i], 1e3 * dn::kDegPerRad * sa[i]);
    std::printf("\n");
  }
  const double rms = std::sqrt(sum2 / (6.0 * static_cast<double>(result.sigma.size())));
  std::printf("%zu nodes, sigma0 %.2f, rms of error / sigma %.2f: %s\n", result.sigma.size(),
              result.figures.sigma0, rms, rms > 0.5 && rms < 1.5 ? "honest" : "not honest");
  return 0;
}
