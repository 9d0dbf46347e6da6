#include <dn/blind_check/blind_flight.h>
#include <dn/blind_check/described_physics.h>
#include <dn/error.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "sim/small_scenario.h"

namespace dn::blind_check_test {

using ::testing::HasSubstr;

std::string Entry(const std::string& text) { return "physics:\n  - {" + text + "}\n"; }

DescribedPhysics One(const std::string& text) { return ParsePhysics(Entry(text), "mine.yaml")[0]; }

/// Draws an effect for a small flight whose strips begin at `begin_s`.
struct DrawnPhysics {
  explicit DrawnPhysics(const std::string& text, std::uint64_t seed = 1)
      : times(PlannedTimes(scenario, 1)), begin_s(times.strips.front().t0_s) {
    Random random(seed, "described");
    effect = DrawDescribedPhysics(One(text), times, random);
    own = MakeOwnErrors(effect, scenario);
  }

  Scenario scenario = testing::SmallScenario();
  FlightTimes times;
  double begin_s;
  UnlistedEffect effect;
  OwnErrors own;
};

TEST(DescribedPhysics, HasTheKeysOfItsEntry) {
  const DescribedPhysics physics =
      One("name: a_1, adds_to: lidar_forward_deg, size: 0.01, shape: sine, of: scan_angle_deg, "
          "period: [8, 30]");
  EXPECT_EQ(physics.name, "a_1");
  EXPECT_EQ(physics.adds_to, "lidar_forward_deg");
  EXPECT_EQ(physics.size, 0.01);
  EXPECT_EQ(physics.shape, "sine");
  EXPECT_EQ(physics.of, "scan_angle_deg");
  EXPECT_EQ(physics.lowest, 8.0);
  EXPECT_EQ(physics.highest, 30.0);
  EXPECT_EQ(One("name: a, adds_to: gnss_m, size: 1, shape: walk").of, "time_s");
}

struct BadEntry {
  const char* entry;
  const char* message;
};

TEST(DescribedPhysics, BadEntriesAreRefusedWithTheirPlace) {
  const BadEntry bad[] = {
      {"name: gravity_tilt, adds_to: gnss_m, size: 1, shape: walk", "the library has"},
      {"name: matcher_shift, adds_to: gnss_m, size: 1, shape: walk", "a second"},
      {"name: 'a b', adds_to: gnss_m, size: 1, shape: walk", "not a name"},
      {"name: a, adds_to: gnss_km, size: 1, shape: walk", "lidar_range_m"},
      {"name: a, adds_to: gnss_m, size: 0, shape: walk", "size"},
      {"name: a, adds_to: gnss_m, size: 1, shape: wave", "per_strip"},
      {"name: a, adds_to: gnss_m, size: 1, shape: walk, period: [1, 2]", "period"},
      {"name: a, adds_to: gnss_m, size: 1, shape: sine, of: range_m, period: [1, 2]", "time_s"},
      {"name: a, adds_to: lidar_range_m, size: 1, shape: walk, of: range_m", "time_s only"},
      {"name: a, adds_to: gnss_m, size: 1, shape: sine, period: [2, 1]", "smaller"},
      {"name: a, adds_to: gnss_m, size: 1, shape: sine, period: [0, 1]", "above 0"},
      {"name: a, adds_to: gnss_m, size: 1, shape: linear, over: [1, 1]", "smaller"},
      {"name: a, adds_to: gnss_m, size: 1, shape: sine", "period"},
      {"name: a, adds_to: lidar_clock_s, size: 1, shape: step, at: [1, 2]", "go back"},
  };
  for (const auto& [entry, message] : bad) {
    try {
      ParsePhysics(Entry(entry), "mine.yaml");
      ADD_FAILURE() << entry << " is accepted";
    } catch (const InvalidConfig& error) {
      EXPECT_THAT(error.what(), HasSubstr(message)) << entry;
      EXPECT_EQ(error.where().file, "mine.yaml") << entry;
      EXPECT_EQ(error.where().line, 2) << entry;
    }
  }
  EXPECT_THROW(ParsePhysics("physics: []", "mine.yaml"), InvalidConfig);
  EXPECT_THROW(ParsePhysics("other: 1", "mine.yaml"), InvalidConfig);
}

TEST(DescribedPhysics, AmplitudesAreOneToTenTimesTheSize) {
  double least = 1e9, most = 0.0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const DrawnPhysics drawn("name: a, adds_to: lidar_range_m, size: 0.02, shape: walk", seed);
    const double size = std::abs(drawn.effect.parameters.at("amplitude")[0].get<double>());
    least = std::min(least, size);
    most = std::max(most, size);
  }
  EXPECT_GE(least, 0.5 * 0.02);
  EXPECT_LT(least, 1.5 * 0.02);
  EXPECT_GT(most, 7.0 * 0.02);
  EXPECT_LE(most, 10.0 * 0.02);
}

TEST(DescribedPhysics, EachQuantityGetsItsErrorInItsUnit) {
  const std::string constant = ", size: 1, shape: step, at: [-1e6, -1e6]";
  const Eigen::Vector3d u_s = 100.0 * Eigen::Vector3d(0.0, 0.6, 0.8);
  const auto amplitude = [](const DrawnPhysics& drawn) {
    const auto value = drawn.effect.parameters.at("amplitude").get<std::vector<double>>();
    return value.size() == 1 ? Eigen::Vector3d(value[0], 0.0, 0.0)
                             : Eigen::Vector3d(value[0], value[1], value[2]);
  };
  const DrawnPhysics gyro("name: a, adds_to: gyro_deg_h" + constant);
  EXPECT_LT((gyro.own.gyro_radps(gyro.begin_s) - amplitude(gyro) * M_PI / 180.0 / 3600.0).norm(),
            1e-18);
  const DrawnPhysics force("name: a, adds_to: accelerometer_mgal" + constant);
  EXPECT_LT((force.own.specific_force_mps2(0.0) - 1e-5 * amplitude(force)).norm(), 1e-18);
  const DrawnPhysics gnss("name: a, adds_to: gnss_m" + constant);
  EXPECT_EQ(gnss.own.antenna_enu_m(0.0), amplitude(gnss));
  const DrawnPhysics boresight("name: a, adds_to: boresight_deg" + constant);
  EXPECT_LT((boresight.own.boresight_rad({}) - amplitude(boresight) * M_PI / 180.0).norm(), 1e-15);
  const DrawnPhysics range("name: a, adds_to: lidar_range_m" + constant);
  EXPECT_NEAR(range.own.laser_vector(u_s, 0.0).norm() - 100.0, amplitude(range).x(), 1e-12);
  const DrawnPhysics scale("name: a, adds_to: lidar_range_ppm" + constant);
  EXPECT_NEAR(scale.own.laser_vector(u_s, 0.0).norm() - 100.0, 1e-4 * amplitude(scale).x(), 1e-12);
}

TEST(DescribedPhysics, AnglesOfTheBeamAreAlongAndAboutTheScanAxis) {
  const std::string constant = ", size: 0.01, shape: step, at: [-1e6, -1e6]";
  const DrawnPhysics forward("name: a, adds_to: lidar_forward_deg" + constant);
  const DrawnPhysics across("name: a, adds_to: lidar_scan_angle_deg" + constant);
  const Eigen::Vector3d axis = forward.scenario.lidar.scan_axis_s;
  const Eigen::Vector3d u_s = 100.0 * forward.scenario.lidar.nadir_axis_s;
  const double forward_deg = forward.effect.parameters.at("amplitude")[0];
  const double across_deg = across.effect.parameters.at("amplitude")[0];
  const Eigen::Vector3d ahead = forward.own.laser_vector(u_s, 0.0) - u_s;
  EXPECT_NEAR(ahead.dot(axis), 100.0 * forward_deg * M_PI / 180.0, 1e-9);
  const Eigen::Vector3d aside = across.own.laser_vector(u_s, 0.0) - u_s;
  EXPECT_NEAR(aside.dot(axis), 0.0, 1e-12);
  EXPECT_NEAR(axis.cross(u_s.normalized()).dot(aside), 100.0 * across_deg * M_PI / 180.0, 1e-9);
}

TEST(DescribedPhysics, ShapesAreFunctionsOfTheirArgument) {
  const auto clock = [](const DrawnPhysics& drawn, double since_s) {
    return drawn.own.lidar_tag_shift_s(drawn.begin_s + since_s) /
           drawn.effect.parameters.at("amplitude")[0].get<double>();
  };
  const std::string lidar = "name: a, adds_to: lidar_clock_s, size: 1e-4, shape: ";
  const DrawnPhysics linear(lidar + "linear, over: [10, 20]");
  EXPECT_NEAR(clock(linear, 5.0), -1.0, 1e-12);
  EXPECT_NEAR(clock(linear, 15.0), 0.0, 1e-9);
  EXPECT_NEAR(clock(linear, 17.5), 0.5, 1e-9);
  EXPECT_NEAR(clock(linear, 30.0), 1.0, 1e-12);
  const DrawnPhysics decay(lidar + "decay, tau: [4, 4]");
  EXPECT_NEAR(clock(decay, -3.0), 1.0, 1e-12);
  EXPECT_NEAR(clock(decay, 4.0), std::exp(-1.0), 1e-9);
  const DrawnPhysics sine(lidar + "sine, period: [6, 6]");
  EXPECT_NEAR(clock(sine, 1.0), clock(sine, 7.0), 1e-9);
  EXPECT_NEAR(clock(sine, 1.0), -clock(sine, 4.0), 1e-9);
  const DrawnPhysics walk(lidar + "walk");
  EXPECT_EQ(clock(walk, 0.0), 0.0);
  EXPECT_NE(clock(walk, 2.0), 0.0);
  const double middle = 0.5 * (clock(walk, 1.0) + clock(walk, 2.0));
  EXPECT_NEAR(clock(walk, 1.5), middle, 1e-9);
}

TEST(DescribedPhysics, AShapePerStripIsConstantWithinIt) {
  const DrawnPhysics drawn("name: a, adds_to: lidar_range_m, size: 0.1, shape: per_strip");
  const Eigen::Vector3d u_s(0.0, 0.0, 100.0);
  ASSERT_GE(drawn.times.strips.size(), 2U);
  const auto& first = drawn.times.strips[0];
  const auto& second = drawn.times.strips[1];
  const auto at = [&](double t_s) { return drawn.own.laser_vector(u_s, t_s).z(); };
  EXPECT_EQ(at(first.t0_s), at(first.t1_s));
  EXPECT_NE(at(first.t1_s), at(second.t0_s));
  EXPECT_EQ(at(second.t0_s), at(second.t1_s));
}

TEST(DescribedPhysics, ABoresightErrorMayFollowTheHeading) {
  const DrawnPhysics drawn(
      "name: a, adds_to: boresight_deg, size: 1, shape: step, of: heading_deg, at: [180, 180]");
  MapPose east, west;  // x forward, y right, z down
  const Eigen::Matrix3d eastward = (Eigen::Matrix3d() << 1, 0, 0, 0, -1, 0, 0, 0, -1).finished();
  east.q_mb = eastward;
  west.q_mb = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ()) * east.q_mb;
  EXPECT_EQ(drawn.own.boresight_rad(east).norm(), 0.0);
  EXPECT_GT(drawn.own.boresight_rad(west).norm(), 0.0);
}

TEST(DescribedPhysics, AnErrorMayFollowRangeAndScanAngle) {
  const std::string shape = ", size: 0.1, shape: step, ";
  const DrawnPhysics far("name: a, adds_to: lidar_range_m" + shape + "of: range_m, at: [50, 50]");
  EXPECT_EQ(far.own.laser_vector({0.0, 0.0, 49.0}, 0.0).z(), 49.0);
  EXPECT_NE(far.own.laser_vector({0.0, 0.0, 51.0}, 0.0).z(), 51.0);
  const DrawnPhysics side("name: a, adds_to: lidar_range_m" + shape +
                          "of: scan_angle_deg, at: [5, 5]");
  const Eigen::Vector3d nadir = side.scenario.lidar.nadir_axis_s;
  const Eigen::Vector3d tilted =
      Eigen::AngleAxisd(0.1, Eigen::Vector3d(side.scenario.lidar.scan_axis_s)) * nadir;
  EXPECT_EQ(side.own.laser_vector(nadir, 0.0), nadir);
  EXPECT_NE(side.own.laser_vector(tilted, 0.0), tilted);
}

TEST(DescribedPhysics, ReplacesTheBuiltInEffectsOfASuite) {
  BlindSuite suite{3, {"leg2_rest"}};
  suite.only = BlindContent::kUnlistedEffect;
  suite.physics = ParsePhysics(
      "physics:\n"
      "  - {name: one, adds_to: gnss_m, size: 0.01, shape: walk}\n"
      "  - {name: two, adds_to: lidar_range_m, size: 0.01, shape: per_strip}\n",
      "mine.yaml");
  std::set<std::string> names;
  for (int number = 1; number <= 12; ++number) {
    names.insert(DrawBlindFlight(suite, number).outsider->name);
  }
  EXPECT_EQ(names, (std::set<std::string>{"one", "two"}));
}

}  // namespace dn::blind_check_test
