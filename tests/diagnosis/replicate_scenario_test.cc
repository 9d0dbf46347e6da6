#include <dn/diagnosis/adapt.h>
#include <dn/diagnosis/replicate_scenario.h>
#include <dn/effects/effect_table.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "testing/expect_invalid.h"
#include "testing/short_flights.h"
#include "testing/temp_folder.h"
#include "testing/tolerances.h"

namespace dn::diagnosis_test {

using testing::Calibration;
using testing::DroneScenario;
using testing::kSigmas;
using testing::TempFolder;

GapCause LidarLate() {
  GapCause cause;
  cause.effect = "lidar_time_offset";
  cause.unit = "s";
  cause.estimate = Eigen::VectorXd::Constant(1, 0.004);
  return cause;
}

/// A drone flight, and its replicate as `dn simulate` makes it from the files of `dn gap`.
struct FlightAndReplicate {
  explicit FlightAndReplicate(const Scenario& scenario, const std::vector<GapCause>& causes = {})
      : flown(Simulate(scenario, {})) {
    const TempFolder folder;
    folder.Write(kReplayTrajectoryFile, FormatSbet(flown.flight.reference->points(), true));
    const Scenario made =
        MakeReplicateScenario(flown.flight, *flown.flight.reference, causes, flown.boresight_rad);
    again = ParseScenario(FormatScenario(made), (folder.path() / "replicate.yaml").string());
    SimulateOptions options;
    options.seed = 7;
    replicate = Simulate(again, options);
  }

  SimulatedFlight flown;
  Scenario again;
  SimulatedFlight replicate;
};

double LargestScanAngle(const Flight& flight) {
  const LidarConfig& lidar = *flight.config.lidar;
  const Eigen::Vector3d side_s = lidar.scan_axis_s.cross(lidar.nadir_axis_s);
  double largest = 0.0;
  for (const LidarPair& pair : flight.pairs->pairs) {
    const double angle = std::atan2(pair.u_i_s.dot(side_s), pair.u_i_s.dot(lidar.nadir_axis_s));
    largest = std::max(largest, std::abs(angle));
  }
  return largest;
}

double PositionApart(const Trajectory& a, const Trajectory& b) {
  const LocalFrame frame(a.points().front().position);
  const std::vector<MapPose> poses = a.ToMapPoses(frame);
  double largest_m = 0.0;
  for (const MapPose& pose : b.ToMapPoses(frame)) {
    if (pose.t_s < a.t_begin_s() || pose.t_s > a.t_end_s()) continue;
    largest_m = std::max(largest_m, (InterpolatePose(poses, pose.t_s).p_mb - pose.p_mb).norm());
  }
  return largest_m;
}

TEST(ReplicateScenario, FliesTheSameStripsWithTheSameSensors) {
  const FlightAndReplicate both(DroneScenario());
  const Flight& flight = both.flown.flight;
  const Flight& replicate = both.replicate.flight;
  constexpr double kSmoothed_m = 0.3;  // a replay is smoothed over a quarter of a second
  EXPECT_LT(PositionApart(*flight.reference, *replicate.reference), kSmoothed_m);
  ASSERT_EQ(both.replicate.strips.size(), both.flown.strips.size());
  for (std::size_t i = 0; i < both.replicate.strips.size(); ++i) {
    EXPECT_EQ(both.replicate.strips[i].name, both.flown.strips[i].name);
    EXPECT_EQ(both.replicate.strips[i].t0_s, both.flown.strips[i].t0_s);
    EXPECT_EQ(both.replicate.strips[i].t1_s, both.flown.strips[i].t1_s);
  }
  EXPECT_EQ(replicate.pairs->files, flight.pairs->files);
  EXPECT_EQ(replicate.pairs->pairs.size(), flight.pairs->pairs.size());
  EXPECT_NEAR(replicate.imu->nominal_dt_s, flight.imu->nominal_dt_s, 1e-9);
  EXPECT_EQ(both.again.gnss.rate_hz, 2.0);
  EXPECT_LE((both.again.gnss.sigma_enu_m - Eigen::Vector3d(0.015, 0.015, 0.03)).norm(), 1e-15);
  EXPECT_EQ(replicate.gnss->epochs[1].t_s - replicate.gnss->epochs[0].t_s, 0.5);
}

TEST(ReplicateScenario, AssumesWhatTheFlightAssumes) {
  const FlightAndReplicate both(DroneScenario());
  FlightConfig expected = both.flown.flight.config;
  expected.name = "drone twin";
  FlightConfig replicate = both.replicate.flight.config;
  replicate.imu->grade = expected.imu->grade;  // the replicate has its noise figures
  EXPECT_EQ(FormatFlightConfig(replicate), FormatFlightConfig(expected));
}

TEST(ReplicateScenario, SeesGroundOfTheSameHeightUnderTheSameAngles) {
  const FlightAndReplicate both(DroneScenario());
  const double range_m = MeanRange(both.flown.flight.pairs->pairs);
  constexpr double kOfRange = 0.05;  // the replicate has no houses
  EXPECT_NEAR(MeanRange(both.replicate.flight.pairs->pairs), range_m, kOfRange * range_m);
  constexpr double kOfAngle = 0.03;
  EXPECT_NEAR(LargestScanAngle(both.replicate.flight), LargestScanAngle(both.flown.flight),
              kOfAngle);
  EXPECT_EQ(both.again.terrain.kind, TerrainKind::kMixed);
}

TEST(ReplicateScenario, FlatGroundStaysFlat) {
  Scenario scenario = DroneScenario();
  scenario.terrain = TerrainScenario{};
  scenario.terrain.kind = TerrainKind::kFlat;
  scenario.terrain.wavelength_m = 100.0;
  scenario.terrain.base_m = -20.0;
  const FlightAndReplicate both(scenario);
  EXPECT_EQ(both.again.terrain.kind, TerrainKind::kFlat);
  EXPECT_NEAR(both.again.terrain.base_m, -20.0, 0.1);  // noise of the pairs, tangent plane
}

TEST(ReplicateScenario, FindsTheConeOfAConicalScanner) {
  Scenario scenario = DroneScenario();
  scenario.lidar.pattern = ScanPattern::kCone;
  scenario.lidar.fov_rad = 40.0 * kRadPerDeg;
  const FlightAndReplicate both(scenario);
  EXPECT_EQ(both.again.lidar.pattern, ScanPattern::kCone);
  EXPECT_NEAR(both.again.lidar.fov_rad, 40.0 * kRadPerDeg, 0.1 * kRadPerDeg);
}

TEST(ReplicateScenario, HoldsTheEffects) {
  FlightAndReplicate both(DroneScenario(), {LidarLate()});
  ASSERT_EQ(both.again.effects.size(), 1u);
  EXPECT_EQ(both.again.effects[0].name, "lidar_time_offset");
  Flight& replicate = both.replicate.flight;
  replicate.config = Adapted(replicate, {LidarLate()});
  const Calibration adjusted(replicate);
  const UnknownEstimate late = adjusted.solution.Unknowns().front();
  EXPECT_NEAR(late.value[0], 0.004, kSigmas * late.sigma[0]);
  EXPECT_LT(late.sigma[0], 0.001);
}

TEST(ReplicateScenario, NamesStripsAsFilesMayBeNamed) {
  SimulatedFlight flown = Simulate(DroneScenario(), {});
  flown.flight.config.strips[1].name = "../back";
  const Scenario replicate =
      MakeReplicateScenario(flown.flight, *flown.flight.reference, {}, {0, 0, 0});
  ASSERT_EQ(replicate.plan.strips.size(), 3u);
  EXPECT_EQ(replicate.plan.strips[1].name, "2");
}

TEST(ReplicateScenario, OfAFlightWithoutPairsHasNone) {
  Scenario scenario = DroneScenario();
  scenario.pairs.count = 0;
  scenario.terrain.base_m = -400.0;  // below the ground that a scenario has by default
  for (PlannedLine& line : scenario.plan.lines) line.height_m -= 200.0;
  const FlightAndReplicate both(scenario);
  EXPECT_EQ(both.again.pairs.count, 0);
  EXPECT_FALSE(both.replicate.flight.pairs.has_value());
  EXPECT_EQ(both.replicate.flight.gnss->epochs[1].t_s - both.replicate.flight.gnss->epochs[0].t_s,
            0.5);
}

TEST(ReplicateScenario, HasTheVibrationThatTheFlightStates) {
  SimulatedFlight flown = Simulate(DroneScenario(), {});
  flown.flight.config.imu->model.vibration = {{381050.0, 381060.0, 0.2 * kRadPerDeg, 0.3}};
  GapCause found;
  found.effect = "imu_vibration";
  found.times.window_s = {381070.0, 381080.0};
  found.estimate = Eigen::Vector2d(0.1, 0.2);
  const Scenario replicate =
      MakeReplicateScenario(flown.flight, *flown.flight.reference, {found}, {0, 0, 0});
  EXPECT_TRUE(replicate.imu.model.vibration.empty());
  ASSERT_EQ(replicate.effects.size(), 2u);
  EXPECT_EQ(replicate.effects[0].name, "imu_vibration");
  EXPECT_EQ(replicate.effects[0].times.window_s, std::pair(381050.0, 381060.0));
  EXPECT_NEAR(replicate.effects[0].value[0], 0.2, 1e-12);
  EXPECT_EQ(replicate.effects[0].value[1], 0.3);
  EXPECT_EQ(replicate.effects[1].times.window_s, found.times.window_s);
}

TEST(ReplicateScenario, RefusesAValueThatTheSimulatorRefuses) {
  GapCause cause = LidarLate();
  cause.estimate[0] = std::numeric_limits<double>::quiet_NaN();
  const SimulatedFlight flown = Simulate(DroneScenario(), {});
  testing::InvalidInputLocation(
      [&] {
        MakeReplicateScenario(flown.flight, *flown.flight.reference, {cause}, {0, 0, 0});
      },
      "lidar_time_offset");
}

}  // namespace dn::diagnosis_test
