#include <dn/diagnosis/result_files.h>
#include <dn/sim/simulate.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace dn::adjustment_test {

struct PublishedAttitude {
  std::string scenario;
  double rp_deg, heading_deg;
};

/// Compares the RMSE of the smoothed attitude with Table 1 of Brun & Skaloud,
/// docs/guides/flight-noise.md.
class FlightNoise : public ::testing::TestWithParam<PublishedAttitude> {};

TEST_P(FlightNoise, SmoothedAttitudeIsThatOfTheGrade) {
  constexpr int kSeeds = 8;
  constexpr double kTolerance = 0.5;
  Scenario scenario = ReadScenario(GetParam().scenario);
  scenario.pairs.count = 0;
  Eigen::Vector3d mean2 = Eigen::Vector3d::Zero();
  for (int seed = 1; seed <= kSeeds; ++seed) {
    SimulateOptions options;
    options.seed = static_cast<std::uint64_t>(seed);
    const SimulatedFlight sim = Simulate(scenario, options);
    AdjustOptions without_lidar;
    without_lidar.with_pairs = false;
    const Adjustment adjustment = Adjust(sim.flight, without_lidar);
    const Json rmse = ReferenceErrorsJson(
        sim.flight, adjustment.network->trajectory().NodePoses())["roll_pitch_heading_rmse_deg"];
    for (int i = 0; i < 3; ++i) {
      mean2[i] += std::pow(rmse[static_cast<std::size_t>(i)].get<double>(), 2) / kSeeds;
    }
  }
  const double rp_deg = std::sqrt(0.5 * (mean2.x() + mean2.y()));
  const double heading_deg = std::sqrt(mean2.z());
  EXPECT_NEAR(rp_deg, GetParam().rp_deg, kTolerance * GetParam().rp_deg);
  EXPECT_NEAR(heading_deg, GetParam().heading_deg, kTolerance * GetParam().heading_deg);
}

INSTANTIATE_TEST_SUITE_P(Grades, FlightNoise,
                         ::testing::Values(PublishedAttitude{"leg4", .005, .010},
                                           PublishedAttitude{"lar3", .002, .005},
                                           PublishedAttitude{"uav3", .025, .080},
                                           PublishedAttitude{"har4", .0025, .005},
                                           PublishedAttitude{"hal4", .005, .008}),
                         [](const auto& tested) { return tested.param.scenario; });

}  // namespace dn::adjustment_test
