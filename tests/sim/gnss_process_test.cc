#include <dn/rotation.h>
#include <dn/sim/simulate.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "small_scenario.h"

namespace dn::sim_test {

using testing::SmallScenario;

SimulatedFlight FlyWithProcess(const std::vector<GnssProcess>& processes, bool noise) {
  Scenario scenario = SmallScenario();
  scenario.pairs.count = 0;
  scenario.gnss.processes = processes;
  SimulateOptions options;
  options.seed = 4;
  options.noise = noise;
  return Simulate(scenario, options);
}

/// Returns the differences of the antenna positions, east, north, up of the map.
std::vector<Eigen::Vector3d> Differences(const SimulatedFlight& a, const SimulatedFlight& b) {
  std::vector<Eigen::Vector3d> differences;
  for (std::size_t k = 0; k < a.flight.gnss->epochs.size(); ++k) {
    differences.emplace_back(a.flight.gnss->epochs[k].p_m - b.flight.gnss->epochs[k].p_m);
  }
  return differences;
}

// The white noise is the same in both flights. The processes add up; the second one has no height
// error.
TEST(GnssProcesses, AreSimulatedAndStated) {
  const std::vector<GnssProcess> processes{{{0.3, 0.0, 0.0}, 2.0}, {{0.4, 0.2, 0.0}, 2.0}};
  const SimulatedFlight with = FlyWithProcess(processes, true), without = FlyWithProcess({}, true);
  EXPECT_EQ(with.flight.config.gnss->processes, processes);
  EXPECT_TRUE(without.flight.config.gnss->processes.empty());
  const std::vector<Eigen::Vector3d> x = Differences(with, without);
  Eigen::Vector3d variance = Eigen::Vector3d::Zero(), lagged = variance;
  for (std::size_t k = 1; k < x.size(); ++k) {
    variance += x[k].cwiseAbs2() / static_cast<double>(x.size());
    lagged += x[k].cwiseProduct(x[k - 1]) / static_cast<double>(x.size());
  }
  // With two epochs a second, every eighth epoch of the record is independent.
  const double tolerance = 4.0 * std::sqrt(2.0 / (static_cast<double>(x.size()) / 8.0));
  EXPECT_NEAR(variance.x() / (0.3 * 0.3 + 0.4 * 0.4), 1.0, tolerance);
  EXPECT_NEAR(variance.y() / (0.2 * 0.2), 1.0, tolerance);
  EXPECT_LT(std::sqrt(variance.z()), 1e-3) << "the local axes are turned by a km of the map";
  EXPECT_NEAR(lagged.x() / variance.x(), std::exp(-0.25), 0.1);
}

// The random numbers are those of the constant error, so that the two differ by the bank only.
TEST(GnssProcesses, GrowWithTheBankIfStated) {
  const GnssProcess constant{{0.3, 0.2, 0.4}, 2.0};
  GnssProcess by_bank = constant;
  by_bank.growth = GnssErrorGrowth::kBank;
  const SimulatedFlight with = FlyWithProcess({by_bank}, true), level = FlyWithProcess({}, true);
  EXPECT_EQ(with.flight.config.gnss->processes, std::vector<GnssProcess>{by_bank});
  const std::vector<Eigen::Vector3d> error = Differences(with, level);
  const std::vector<Eigen::Vector3d> usual = Differences(FlyWithProcess({constant}, true), level);
  for (std::size_t k = 0; k < error.size(); ++k) {
    const NavPoint truth = with.truth->Nav(with.flight.gnss->epochs[k].t_s);
    const double ratio = std::abs(RollPitchHeading(truth.q_nb).x()) / (std::numbers::pi / 6.0);
    ASSERT_LT((error[k] - ratio * usual[k]).norm(), 1e-6) << k;
  }
}

TEST(GnssProcesses, AreLeftOutOfAFlightWithoutNoise) {
  const std::vector<GnssProcess> processes{{{0.3, 0.2, 0.1}, 2.0}};
  for (const Eigen::Vector3d& x :
       Differences(FlyWithProcess(processes, false), FlyWithProcess({}, false))) {
    ASSERT_EQ(x, Eigen::Vector3d::Zero());
  }
}

TEST(GnssProcesses, AreReadAsInAFlight) {
  const Scenario scenario = ParseScenario(
      "name: s\norigin_deg_m: [46.57, 6.52, 400]\nstart_s: 381000\n"
      "plan: {lines: [[-500, 0, 500, 0, 200, 45]]}\nimu: {preset: ln200}\n"
      "lidar: {gsd_m: 0.2}\n"
      "gnss: {processes: [{type: gauss_markov, sigma_enu_m: [0, 0.1, 0.2], tau_s: 60}, "
      "{type: gauss_markov, sigma_enu_m: [0, 0.1, 0.2], tau_s: 60, grows_with: bank}]}\n",
      "s.yaml");
  ASSERT_EQ(scenario.gnss.processes.size(), 2U);
  EXPECT_EQ(scenario.gnss.processes[0], (GnssProcess{{0.0, 0.1, 0.2}, 60.0}));
  EXPECT_EQ(scenario.gnss.processes[1],
            (GnssProcess{{0.0, 0.1, 0.2}, 60.0, GnssErrorGrowth::kBank}));
}

}  // namespace dn::sim_test
