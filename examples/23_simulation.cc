// A simulated flight: a scenario in C++, the measurements, and the truth behind them.
//
// Three lines are flown with the sensors of a shipped scenario, without vibration. Compares angular
// rates, GNSS and point pairs with the truth. Fails unless their noise is the stated one, as far as
// chance allows.
#include <dn/sim/simulate.h>

#include <cmath>
#include <cstdio>

/// Errors divided by their stated sigmas.
struct Ratio {
  double sum2 = 0.0, count = 0.0;

  void Add(const Eigen::Vector3d& error, const Eigen::Vector3d& sigma) {
    sum2 += error.cwiseQuotient(sigma).squaredNorm();
    count += 3.0;
  }
  bool Check(const char* name) const {
    const double ratio = std::sqrt(sum2 / count), limit = 4.0 / std::sqrt(2.0 * count);
    std::printf("%-10s %7.0f values, noise %.3f times the stated one\n", name, count, ratio);
    return std::abs(ratio - 1.0) < limit;
  }
};

int main() {
  dn::Scenario scenario = dn::ReadScenario("lar2_rest");
  scenario.plan.warm_up_s = 30.0;
  scenario.plan.lines = {{{-600, 0}, {600, 0}, 700, 45},  // start, end [m], height [m], speed [m/s]
                         {{600, 120}, {-600, 120}, 700, 45},
                         {{0, -600}, {0, 600}, 760, 45}};
  scenario.pairs.count = 1000;
  scenario.lidar.mounting.boresight_rad = dn::kRadPerDeg * Eigen::Vector3d(0.5, -0.2, 1.0);
  const dn::SimulatedFlight sim = dn::Simulate(scenario, {.seed = 7});

  Ratio gyro, gnss, pairs;
  for (std::size_t k = 0; k < sim.flight.imu->samples.size(); ++k) {
    const dn::ImuSample& sample = sim.flight.imu->samples[k];
    const double t_s = sample.t_s, dt_s = sample.dt_s;
    const Eigen::Vector3d mean =  // of the interval, by Simpson's rule
        (sim.truth->AngularRate(t_s - dt_s) + 4.0 * sim.truth->AngularRate(t_s - 0.5 * dt_s) +
         sim.truth->AngularRate(t_s)) /
        6.0;
    gyro.Add(sample.w_ib_b_radps - mean - sim.gyro_bias_radps[k],
             Eigen::Vector3d::Constant(scenario.imu.model.gyro.white / std::sqrt(dt_s)));
  }
  for (const dn::MapGnssEpoch& epoch : sim.flight.gnss->epochs) {
    const dn::MapPose pose = sim.truth->Pose(epoch.t_s);
    const Eigen::Vector3d antenna_m = pose.p_mb + pose.q_mb * sim.gnss_lever_arm_b_m;
    gnss.Add(epoch.R_m_enu.transpose() * (epoch.p_m - antenna_m), scenario.gnss.sigma_enu_m);
  }
  for (const dn::LidarPair& pair : sim.flight.pairs->pairs) {
    const auto point = [&](double t_s, const Eigen::Vector3d& u_s) {
      return dn::Georeference(sim.truth->Pose(t_s), scenario.lidar.mounting, u_s);
    };
    pairs.Add(point(pair.t_i_s, pair.u_i_s) - point(pair.t_j_s, pair.u_j_s),
              Eigen::Vector3d::Constant(scenario.pairs.sigma_p_m));
  }
  const bool right[] = {gyro.Check("gyros"), gnss.Check("GNSS"), pairs.Check("pairs")};
  return right[0] && right[1] && right[2] ? 0 : 1;
}
