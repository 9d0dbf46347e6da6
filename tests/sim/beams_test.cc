#include <dn/lidar/strip_io.h>
#include <dn/rotation.h>
#include <dn/sim/simulate.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <set>
#include <string>

#include "sim/small_scenario.h"
#include "sim/written_flight.h"
#include "testing/expect_invalid.h"
#include "testing/temp_folder.h"

namespace dn::sim_test {

using Eigen::Vector3d;
using ::testing::HasSubstr;

/// Returns SmallScenario with a rotating scanner of four beams.
Scenario RotatingScenario(const std::string& beams) {
  std::string text = FormatScenario(testing::SmallScenario());
  text.replace(text.find("pattern: line"), 13, "pattern: rotating");
  const std::string gsd = "  gsd_m:";
  return ParseScenario(text.replace(text.find(gsd), 0, "  beams: " + beams + "\n"), "beams.yaml");
}

constexpr const char* kStated =
    "{angles_deg: [-15, -5, 5, 15], angle_error_deg: [0.2, -0.1, 0, 0.3], "
    "range_error_m: [0.05, -0.02, 0.01, 0]}";

/// Returns the true laser vector of a reported one: the definition of the errors.
Vector3d TrueVector(const BeamScenario& beams, const Vector3d& axis, const Vector3d& u_s,
                    int beam) {
  const auto k = static_cast<std::size_t>(beam);
  const Vector3d shorter = (1.0 - beams.range_error_m[k] / u_s.norm()) * u_s;
  const Vector3d across = axis.cross(shorter).normalized();
  return Eigen::AngleAxisd(-beams.angle_error_rad[k], across) * shorter;
}

TEST(RotatingScanner, EveryBeamReportsItsAssumedAngleAndSeesTheGroundAtItsTrueOne) {
  const Scenario scenario = RotatingScenario(kStated);
  const SimulatedFlight sim = Simulate(scenario, {.noise = false});
  const Vector3d axis = scenario.lidar.scan_axis_s;
  Mounting mounting = sim.flight.config.lidar->mounting;
  mounting.boresight_rad = sim.boresight_rad;
  const auto ground = [&](double t_s, const Vector3d& u_s, int beam) {
    const double angle_rad = std::asin(u_s.normalized().dot(axis));
    EXPECT_NEAR(angle_rad, scenario.lidar.beams.angles_rad[static_cast<std::size_t>(beam)], 1e-9);
    return Georeference(sim.truth->Pose(t_s), mounting,
                        TrueVector(scenario.lidar.beams, axis, u_s, beam));
  };
  std::set<int> seen;
  ASSERT_EQ(sim.flight.pairs->pairs.size(), 300u);
  for (const LidarPair& pair : sim.flight.pairs->pairs) {
    seen.insert({pair.beam_i, pair.beam_j});
    const Vector3d p_i = ground(pair.t_i_s, pair.u_i_s, pair.beam_i);
    const Vector3d p_j = ground(pair.t_j_s, pair.u_j_s, pair.beam_j);
    EXPECT_LT((p_i - p_j).norm(), 1e-5);
  }
  EXPECT_EQ(seen, (std::set<int>{0, 1, 2, 3}));
  EXPECT_EQ(sim.flight.config.lidar->beams->angles_rad, scenario.lidar.beams.angles_rad);
}

TEST(RotatingScanner, ErrorsThatAreNotStatedAreDrawnWithoutAMean) {
  const Scenario scenario = RotatingScenario(
      "{angles_deg: [-15, -5, 5, 15], angle_sigma_deg: 0.1, range_offset_sigma_m: 0}");
  const SimulatedFlight one = Simulate(scenario, {.seed = 3}), other = Simulate(scenario, {});
  const BeamScenario &a = one.scenario.lidar.beams, &b = other.scenario.lidar.beams;
  ASSERT_EQ(a.angle_error_rad.size(), 4u);
  EXPECT_NE(a.angle_error_rad, b.angle_error_rad);
  EXPECT_NEAR(std::accumulate(a.angle_error_rad.begin(), a.angle_error_rad.end(), 0.0), 0.0, 1e-15);
  EXPECT_EQ(a.range_error_m, std::vector<double>(4, 0.0));
  EXPECT_THAT(FormatTruth(one), HasSubstr("beams: {angle_error_deg: ["));
  EXPECT_THAT(FormatTruth(Simulate(testing::SmallScenario(), {})),
              ::testing::Not(HasSubstr("beams")));
}

TEST(RotatingScanner, IsReadAsWritten) {
  const Scenario scenario = RotatingScenario(kStated);
  const Scenario again = ParseScenario(FormatScenario(scenario), "again.yaml");
  EXPECT_EQ(again.lidar.beams.angle_error_rad, scenario.lidar.beams.angle_error_rad);
  EXPECT_EQ(again.lidar.beams.range_error_m, scenario.lidar.beams.range_error_m);
  EXPECT_EQ(again.lidar.pattern, ScanPattern::kRotating);
  const SimulatedFlight sim = Simulate(scenario, {.seed = 4});
  const Flight read = WrittenAndRead(sim);
  ASSERT_EQ(read.pairs->pairs.size(), sim.flight.pairs->pairs.size());
  for (std::size_t k = 0; k < read.pairs->pairs.size(); ++k) {
    EXPECT_EQ(read.pairs->pairs[k].beam_i, sim.flight.pairs->pairs[k].beam_i);
    EXPECT_EQ(read.pairs->pairs[k].beam_j, sim.flight.pairs->pairs[k].beam_j);
  }
}

TEST(RotatingScanner, PointCloudsHaveTheBeamOfEveryPoint) {
  Scenario scenario = RotatingScenario(kStated);
  scenario.strips = true;
  scenario.lidar.pulse_rate_hz = 2000.0;
  const SimulatedFlight sim = Simulate(scenario, {.noise = false});
  const testing::TempFolder folder;
  {
    OutputDirectory directory(folder.path() / "flight");
    WriteClouds(sim, 1, directory, {});
    directory.Commit();
  }
  StripCloud points;
  ASSERT_TRUE(OpenStrip(folder.path() / "flight/strips/1.las")->Next(&points));
  ASSERT_EQ(points.beam.size(), points.size());
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double angle_rad = std::asin(points.u_s[k].normalized().dot(scenario.lidar.scan_axis_s));
    ASSERT_NEAR(angle_rad, scenario.lidar.beams.angles_rad[points.beam[k]], 1e-9);
  }
  // A quarter turn of 75 deg out of 360 deg looks at the ground.
  EXPECT_GT(points.size(), 1000u);
}

TEST(RotatingScanner, MistakesAreNamed) {
  const auto refused = [](const std::string& beams, const char* why) {
    testing::InvalidInputLocation([&] { RotatingScenario(beams); }, why);
  };
  refused("{}", "angles_deg");
  refused("{angles_deg: [0, 1], angle_error_deg: [0]}", "one per beam: 2");
  refused("{angles_deg: [0, 1], rotation_hz: 0}", "rotation_hz");
  refused("~", "needs `beams`");
  std::string text = FormatScenario(RotatingScenario(kStated));
  text.replace(text.find("pattern: rotating"), 17, "pattern: line");
  testing::InvalidInputLocation([&] { ParseScenario(text, "line.yaml"); }, "must be rotating");
}

}  // namespace dn::sim_test
