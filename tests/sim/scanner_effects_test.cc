#include <dn/rotation.h>
#include <dn/sim/simulate.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>

#include "sim/small_scenario.h"

namespace dn::sim_test {

using Eigen::Vector3d;

constexpr double kSamePoint_m = 1e-6;  // sweep times are accurate to 1e-10 s, spans to 1e-7 s

SimulatedFlight Exact(const std::string& effects) {
  SimulateOptions options;
  options.noise = false;
  return Simulate(testing::SmallScenario("effects: [" + effects + "]\n"), options);
}

/// Model of the scanner that a test assumes.
struct Belief {
  std::function<Vector3d(double t_s)> boresight_rad;
  std::function<Vector3d(const Vector3d& u_s)> true_vector = [](const Vector3d& u_s) {
    return u_s;
  };
};

/// Returns the ground point p = n + R_b^m (Exp(theta) T u + a).
Vector3d Ground(const SimulatedFlight& flight, const Belief& belief, double t_s,
                const Vector3d& u_s) {
  const MapPose pose = flight.truth->Pose(t_s);
  const Vector3d u_b = Exp(belief.boresight_rad(t_s)) *
                       (flight.scenario.lidar.mounting.R_bs_nominal * belief.true_vector(u_s));
  return pose.p_mb + pose.q_mb * (u_b + flight.lidar_lever_arm_b_m);
}

/// Returns the largest distance between the two ends of a pair.
double LargestMisfit(const SimulatedFlight& flight, const Belief& belief) {
  double largest_m = 0.0;
  for (const LidarPair& pair : flight.flight.pairs->pairs) {
    const Vector3d d = Ground(flight, belief, pair.t_i_s, pair.u_i_s) -
                       Ground(flight, belief, pair.t_j_s, pair.u_j_s);
    largest_m = std::max(largest_m, d.norm());
  }
  return largest_m;
}

Belief Assumed(const SimulatedFlight& flight) {
  return {[boresight_rad = flight.boresight_rad](double) { return boresight_rad; }};
}

double PairsMiddle(const SimulatedFlight& flight) {
  double first_s = 1e300, last_s = 0.0;
  for (const LidarPair& pair : flight.flight.pairs->pairs) {
    first_s = std::min({first_s, pair.t_i_s, pair.t_j_s});
    last_s = std::max({last_s, pair.t_i_s, pair.t_j_s});
  }
  return 0.5 * (first_s + last_s);
}

TEST(ScannerEffects, WithoutAnyThePairsMeet) {
  const SimulatedFlight flight = Exact("");
  EXPECT_LT(LargestMisfit(flight, Assumed(flight)), kSamePoint_m);
}

TEST(ScannerEffects, BoresightDriftsAboutTheMiddleOfThePairs) {
  const SimulatedFlight flight = Exact("{effect: boresight_drift, value: [3, -2, 1]}");
  const Vector3d rate_radps = kRadPerDeg / 3600.0 * Vector3d(3.0, -2.0, 1.0);
  const double middle_s = PairsMiddle(flight);
  Belief belief;
  belief.boresight_rad = [&](double t_s) {
    return Vector3d(flight.boresight_rad + rate_radps * (t_s - middle_s));
  };
  EXPECT_LT(LargestMisfit(flight, belief), kSamePoint_m);
  EXPECT_GT(LargestMisfit(flight, Assumed(flight)), 0.05);
  belief.boresight_rad = [&](double t_s) {
    return Vector3d(flight.boresight_rad + rate_radps * (t_s - middle_s - 30.0));
  };
  EXPECT_GT(LargestMisfit(flight, belief), 100.0 * kSamePoint_m) << "the middle matters";
}

// The step is within the second strip.
TEST(ScannerEffects, BoresightStepsAtItsTime) {
  const SimulatedFlight clean = Exact("");
  const double t0_s = 0.5 * (clean.strips[1].t0_s + clean.strips[1].t1_s);
  const SimulatedFlight flight = Exact(
      "{effect: boresight_step, value: [0.1, -0.2, 0.3], t0_s: " + std::to_string(t0_s) + "}");
  const Vector3d step_rad = kRadPerDeg * Vector3d(0.1, -0.2, 0.3);
  Belief belief;
  belief.boresight_rad = [&](double t_s) {
    return t_s >= t0_s ? Vector3d(flight.boresight_rad + step_rad) : flight.boresight_rad;
  };
  EXPECT_LT(LargestMisfit(flight, belief), kSamePoint_m);
  EXPECT_GT(LargestMisfit(flight, Assumed(flight)), 0.2);
  EXPECT_EQ(flight.boresight_rad, clean.boresight_rad) << "the boresight is that before the step";
  const auto& pairs = flight.flight.pairs->pairs;
  EXPECT_EQ(pairs.size(), clean.flight.pairs->pairs.size());
  const auto inside = std::count_if(pairs.begin(), pairs.end(), [&](const LidarPair& pair) {
    return pair.t_j_s > clean.strips[1].t0_s && pair.t_j_s < t0_s;
  });
  EXPECT_GT(inside, 10) << "pairs of the strip before the step";
}

TEST(ScannerEffects, BeamLeavesTheScanPlaneButNotInTheFile) {
  const SimulatedFlight flight = Exact("{effect: lidar_scan_cone, value: 0.5}");
  const double cone = 0.5 * kRadPerDeg;
  const Vector3d& axis = flight.scenario.lidar.scan_axis_s;
  for (const LidarPair& pair : flight.flight.pairs->pairs) {
    ASSERT_LT(std::abs(pair.u_i_s.dot(axis)), 1e-9);
    ASSERT_LT(std::abs(pair.u_j_s.dot(axis)), 1e-9);
  }
  Belief belief = Assumed(flight);
  belief.true_vector = [&](const Vector3d& u_s) {
    return Vector3d(std::cos(cone) * u_s + std::sin(cone) * u_s.norm() * axis);
  };
  EXPECT_LT(LargestMisfit(flight, belief), kSamePoint_m);
  EXPECT_GT(LargestMisfit(flight, Assumed(flight)), 1.0);
}

TEST(ScannerEffects, ATwistedMirrorLeansTheBeamByItsScanAngle) {
  const SimulatedFlight flight = Exact("{effect: lidar_scan_torsion, value: 0.5}");
  const LidarScenario& lidar = flight.scenario.lidar;
  for (const LidarPair& pair : flight.flight.pairs->pairs) {
    ASSERT_LT(std::abs(pair.u_i_s.dot(lidar.scan_axis_s)), 1e-9);
  }
  const Vector3d across = lidar.scan_axis_s.cross(lidar.nadir_axis_s);
  Belief belief = Assumed(flight);
  belief.true_vector = [&](const Vector3d& u_s) {
    const double angle = std::atan2(u_s.dot(across), u_s.dot(lidar.nadir_axis_s));
    const double lean = 0.5 * kRadPerDeg * std::sin(4.0 * angle);
    return Vector3d(std::cos(lean) * u_s + std::sin(lean) * u_s.norm() * lidar.scan_axis_s);
  };
  EXPECT_LT(LargestMisfit(flight, belief), kSamePoint_m);
  EXPECT_GT(LargestMisfit(flight, Assumed(flight)), 0.5);
}

// The file assumes beams on the cone; the true beam is closer to the scan axis.
TEST(ScannerEffects, ABeamOfAConeIsTurnedTowardTheScanAxis) {
  Scenario scenario = testing::SmallScenario("effects: [{effect: lidar_scan_cone, value: 0.5}]\n");
  scenario.lidar.pattern = ScanPattern::kCone;
  SimulateOptions options;
  options.noise = false;
  const SimulatedFlight flight = Simulate(scenario, options);
  const double turn = 0.5 * kRadPerDeg;
  const Vector3d& axis = scenario.lidar.scan_axis_s;
  for (const LidarPair& pair : flight.flight.pairs->pairs) {
    ASSERT_NEAR(pair.u_i_s.dot(scenario.lidar.nadir_axis_s),
                pair.u_i_s.norm() * std::cos(0.5 * scenario.lidar.fov_rad), kSamePoint_m);
  }
  Belief belief = Assumed(flight);
  belief.true_vector = [&](const Vector3d& u_s) {
    return Vector3d(Eigen::AngleAxisd(turn, u_s.cross(axis).normalized()) * u_s);
  };
  EXPECT_LT(LargestMisfit(flight, belief), kSamePoint_m);
  EXPECT_GT(LargestMisfit(flight, Assumed(flight)), 1.0);
}

// The beam has left the scan plane. The effects apply to its measured scan angle (by projection),
// then to the range.
TEST(ScannerEffects, ConeAngleAndRangeApplyInThisOrder) {
  const SimulatedFlight flight = Exact(
      "{effect: lidar_range_offset, value: 0.3}, {effect: lidar_range_scale, value: 2000},"
      "{effect: lidar_angle_scale, value: 5000}, {effect: lidar_scan_cone, value: -1}");
  const LidarScenario& lidar = flight.scenario.lidar;
  const double cone = -kRadPerDeg;
  const Vector3d across = lidar.scan_axis_s.cross(lidar.nadir_axis_s);
  Belief belief = Assumed(flight);
  belief.true_vector = [&](const Vector3d& u_s) {
    const double range_m = (u_s.norm() - 0.3) / 1.002;
    const double angle = std::atan2(u_s.dot(across), u_s.dot(lidar.nadir_axis_s)) / 1.005;
    const Vector3d in_plane = std::cos(angle) * lidar.nadir_axis_s + std::sin(angle) * across;
    return Vector3d(range_m * (std::cos(cone) * in_plane + std::sin(cone) * lidar.scan_axis_s));
  };
  EXPECT_LT(LargestMisfit(flight, belief), kSamePoint_m);
}

}  // namespace dn::sim_test
