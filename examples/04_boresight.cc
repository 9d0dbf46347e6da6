// The boresight of a simulated flight, in memory: IMU, GNSS and lidar point pairs in one network.
//
// Prints the true angles, and the estimates with their standard deviations. Also prints the
// correlation of the boresight with the biases, and whether the data agree with the model.
#include <dn/adjustment/words.h>
#include <dn/axis_names.h>
#include <dn/diagnosis/solution.h>
#include <dn/sim/simulate.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

int main() {
  dn::Scenario scenario = dn::ReadScenario("lar2");
  scenario.plan.warm_up_s = 120.0;
  scenario.imu.rate_hz = 100.0;
  scenario.pairs.count = 500;
  const dn::SimulatedFlight sim = dn::Simulate(scenario, {});

  const dn::Solution solution(sim.flight);
  const dn::BoresightResult boresight = solution.CheckedBoresight();
  const dn::Adjustment& adjustment = solution.adjustment();

  std::printf("aligned %s, %zu nodes, %ld pairs rejected, mean distance of pairs %.2f -> %.2f m\n",
              adjustment.alignment_method.c_str(), adjustment.network->nodes().size(),
              adjustment.outliers, adjustment.residual_initial_m, adjustment.residual_final_m);
  const Eigen::Vector3d sigma_rad = boresight.sigma_rad();
  double worst = 0.0;
  for (int i = 0; i < 3; ++i) {
    const double error_rad = boresight.angles_rad[i] - sim.boresight_rad[i];
    worst = std::max(worst, std::abs(error_rad) / sigma_rad[i]);
    std::printf("%-5s  truth %.4f deg  estimate %.4f deg  sigma %.4f deg\n", dn::kRollPitchYaw[i],
                dn::kDegPerRad * sim.boresight_rad[i], dn::kDegPerRad * boresight.angles_rad[i],
                dn::kDegPerRad * sigma_rad[i]);
  }
  std::printf("correlation with the biases: gyro %.2f, accelerometer %.2f\n",
              boresight.gyro_bias.max_abs, boresight.accel_bias.max_abs);
  std::printf("%s, %s four sigmas of the truth\n", dn::Word(boresight.verdict),
              worst < 4.0 ? "within" : "beyond");
  return worst < 4.0 ? 0 : 1;
}
