// A network with a node at every inertial sample gives the same adjustment as preintegrated
// increments.
#include <dn/adjustment/adjust.h>
#include <dn/rotation.h>
#include <dn/sim/random.h>
#include <dn/solvers/marginals.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "testing/short_flights.h"

namespace dn::adjustment_test {

using testing::Calibration;

constexpr double kNodeRateHz = 10.0;
constexpr double kSigmaPairM = 0.03;

/// Two opposite strips at different heights, 1.5 minutes in total; the flight ends eight seconds
/// after the second one.
SimulatedFlight TwoStrips() {
  Scenario scenario = testing::DroneScenario();
  scenario.imu.rate_hz = 50.0;
  scenario.plan.warm_up_s = 20.0;
  scenario.plan.lines.pop_back();
  scenario.plan.lines.back().height_m += 20.0;
  scenario.pairs.sigma_p_m = kSigmaPairM;
  SimulateOptions options;
  options.seed = 3;
  SimulatedFlight sim = Simulate(scenario, options);
  const double end_s = sim.strips.back().t1_s + 8.0;
  std::erase_if(sim.flight.imu->samples, [&](const ImuSample& s) { return s.t_s > end_s; });
  std::erase_if(sim.flight.gnss->epochs, [&](const MapGnssEpoch& e) { return e.t_s > end_s; });
  return sim;
}

/// Returns the laser vector u = T^T Exp(-theta) (R^T (P - p) - a), with half of the pair's noise.
Eigen::Vector3d Sight(const SimulatedFlight& sim, double t_s, const Eigen::Vector3d& point_m,
                      Random& random) {
  const Mounting& mounting = sim.scenario.lidar.mounting;
  const MapPose pose = sim.truth->Pose(t_s);
  const Eigen::Vector3d arm_b =
      pose.q_mb.conjugate() * (point_m - pose.p_mb) - sim.lidar_lever_arm_b_m;
  return mounting.R_bs_nominal.transpose() * (Exp(mounting.boresight_rad).conjugate() * arm_b) +
         kSigmaPairM / std::numbers::sqrt2 * random.Normal3();
}

/// Makes pairs whose epochs are nodes of both grids.
std::vector<LidarPair> PairsOnNodes(const SimulatedFlight& sim) {
  constexpr int kPairs = 300;
  Random random(7, "pairs on nodes");
  const auto tick = [&](const StripInterval& strip) {
    return std::round(random.Uniform(strip.t0_s, strip.t1_s) * kNodeRateHz) / kNodeRateHz;
  };
  std::vector<LidarPair> pairs;
  for (int k = 0; k < kPairs; ++k) {
    LidarPair pair;
    pair.t_i_s = tick(sim.strips[0]);
    pair.t_j_s = tick(sim.strips[1]);
    const Eigen::Vector3d point_m(random.Uniform(-100.0, 100.0), random.Uniform(-30.0, 60.0),
                                  random.Uniform(-5.0, 5.0));
    pair.u_i_s = Sight(sim, pair.t_i_s, point_m, random);
    pair.u_j_s = Sight(sim, pair.t_j_s, point_m, random);
    pairs.push_back(pair);
  }
  return pairs;
}

BoresightResult Solve(Flight flight, NetworkConfig::Inertial inertial) {
  flight.config.network.inertial = inertial;
  flight.config.network.node_rate_hz = kNodeRateHz;
  AdjustOptions options;
  options.network.bias_interval_max_s = 5.0;  // intervals end at nodes of both grids
  return Calibration(flight, options).boresight;
}

/// Expects angles within `of_sigma` sigmas and sigmas within the relative tolerance `relative`.
void ExpectSameBoresight(const Flight& flight, double of_sigma, double relative) {
  const BoresightResult raw = Solve(flight, NetworkConfig::Inertial::kRaw);
  const BoresightResult increments = Solve(flight, NetworkConfig::Inertial::kPreintegrated);
  const Eigen::Vector3d sigma = raw.sigma_rad();
  for (int i = 0; i < 3; ++i) {
    SCOPED_TRACE("component " + std::to_string(i));
    EXPECT_LT(std::abs(increments.angles_rad[i] - raw.angles_rad[i]), of_sigma * sigma[i]);
    EXPECT_NEAR(increments.sigma_rad()[i] / sigma[i], 1.0, relative);
  }
}

TEST(RawInertial, EqualsPreintegrationWherePairsAreOnNodes) {
  SimulatedFlight sim = TwoStrips();
  sim.flight.pairs->pairs = PairsOnNodes(sim);
  ExpectSameBoresight(sim.flight, 1e-3, 1e-3);
}

// Between nodes, the noise of the partial increment counts for each pair separately.
TEST(RawInertialManyRuns, IsCloseToPreintegrationWherePairsLieBetweenNodes) {
  ExpectSameBoresight(TwoStrips().flight, 0.02, 0.01);
}

/// Returns the flight with some wrong pairs and GNSS epochs, adjusted with raw inertial data.
Adjustment AdjustSpoilt(Flight flight, const std::function<void(FlightNetwork&)>& before_lidar) {
  for (const std::size_t k : {5u, 50u}) flight.pairs->pairs[k].u_i_s += Eigen::Vector3d(3, -4, 5);
  flight.gnss->epochs[20].p_m += Eigen::Vector3d(2.0, 0.0, -3.0);
  flight.config.network.inertial = NetworkConfig::Inertial::kRaw;
  AdjustOptions options;
  options.customise_before_lidar = before_lidar;
  return Adjust(flight, options);
}

// By default, data are rejected with larger node spacing. If customise_before_lidar is set, they
// are rejected at the inertial rate.
TEST(RawInertialManyRuns, IsTheSameWhereItIsTakenLast) {
  constexpr double kSame = 1e-4;  // in sigmas; the solutions converge to steps of 1e-3
  // Relative tolerance: half the square of the last step, 1e-3 sigma, divided by a cost of some
  // hundred.
  constexpr double kSameCost = 1e-7;
  const Flight flight = TwoStrips().flight;
  const Adjustment last = AdjustSpoilt(flight, {});
  const Adjustment first = AdjustSpoilt(flight, [](FlightNetwork&) {});
  ASSERT_EQ(last.network->nodes().size(), first.network->nodes().size());
  EXPECT_EQ(last.outliers, first.outliers);
  EXPECT_GE(last.outliers, 2);
  EXPECT_EQ(last.gnss_rejected, first.gnss_rejected);
  EXPECT_EQ(last.gnss_rejected, std::vector<std::size_t>{20});
  const Marginals marginals(first.network->net());
  const Eigen::Vector3d sigma =
      marginals.Covariance(first.network->calibration().boresight().id).diagonal().cwiseSqrt();
  const Eigen::Vector3d apart =
      Log<double>(last.network->net().Value(last.network->calibration().boresight()) *
                  first.network->net().Value(first.network->calibration().boresight()).conjugate());
  EXPECT_LT(apart.cwiseQuotient(sigma).norm(), kSame);
  EXPECT_NEAR(last.cost / first.cost, 1.0, kSameCost);
}

}  // namespace dn::adjustment_test
