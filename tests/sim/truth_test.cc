#include <dn/error.h>
#include <dn/rotation.h>
#include <dn/sim/simulate.h>
#include <dn/sim/truth.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/rates_are_derivatives.h"
#include "sim/small_scenario.h"

namespace dn::sim_test {

using Eigen::Quaterniond;
using Eigen::Vector3d;

SimulatedFlight FlyWithoutPairs(Scenario scenario) {
  scenario.pairs.count = 0;
  return Simulate(scenario, {});
}

TEST(TruthTrajectory, RatesAreDerivativesOfThePose) {
  const SimulatedFlight flight = FlyWithoutPairs(testing::SmallScenario());
  // Errors of fourth-order differences for motion up to 1 Hz at this step, with margin.
  ExpectRatesAreDerivatives(*flight.truth, 1.0 / 64.0,
                            {.velocity_mps = 1e-5, .acceleration_mps2 = 1e-4, .rate_radps = 1e-6});
}

/// Strapdown navigation in the inertial frame that coincides with m at t0, by the classical
/// Runge-Kutta method. It is written from Newton's law, without any term of a rotating frame.
struct InertialState {
  Vector3d r, v;
  Eigen::Vector4d q;  // x, y, z, w of body to inertial

  InertialState Plus(const InertialState& rate, double h) const {
    return {r + h * rate.r, v + h * rate.v, q + h * rate.q};
  }
};

InertialState Derivative(const TruthTrajectory& truth, const InertialState& x, double t_s,
                         double t0_s) {
  const LocalFrame& frame = truth.frame();
  const TruthState sensors = truth.State(t_s);
  const Vector3d& w = frame.w_ie_m();
  const Quaterniond q_im(Eigen::AngleAxisd(w.norm() * (t_s - t0_s), w.normalized()));
  const Vector3d p_m = q_im.conjugate() * x.r - frame.r0_m();
  const Quaterniond q_ib(x.q);
  const Quaterniond half_rate(0.0, 0.5 * sensors.w_ib_b.x(), 0.5 * sensors.w_ib_b.y(),
                              0.5 * sensors.w_ib_b.z());
  return {x.v, q_ib.normalized() * sensors.f_b + q_im * frame.Gravitation(p_m),
          (q_ib * half_rate).coeffs()};
}

TEST(TruthTrajectory, SensorsIntegrateToTheTrajectoryInInertialSpace) {
  const SimulatedFlight flight = FlyWithoutPairs(testing::SmallScenario());
  const TruthTrajectory& truth = *flight.truth;
  const LocalFrame& frame = truth.frame();
  const double t0_s = flight.strips[0].t0_s;
  constexpr double kSpan_s = 60.0;  // the strip and the turn after it
  constexpr int kSteps = 6000;
  constexpr double kStep_s = kSpan_s / kSteps;
  // Rounding of 6.4e6 m over 6000 steps; a wrong term would give metres.
  constexpr double kPosition_m = 1e-5;
  constexpr double kAttitude_rad = 1e-9;

  const TruthState begin = truth.State(t0_s);
  const Vector3d& w = frame.w_ie_m();
  const Vector3d r0 = frame.r0_m() + begin.pose.p_mb;
  InertialState x{r0, begin.pose.v_m + w.cross(r0), begin.pose.q_mb.coeffs()};
  double turned_rad = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double t_s = t0_s + i * kStep_s;
    const double middle_s = t_s + 0.5 * kStep_s, end_s = t_s + kStep_s;
    const InertialState k1 = Derivative(truth, x, t_s, t0_s);
    const InertialState k2 = Derivative(truth, x.Plus(k1, 0.5 * kStep_s), middle_s, t0_s);
    const InertialState k3 = Derivative(truth, x.Plus(k2, 0.5 * kStep_s), middle_s, t0_s);
    const InertialState k4 = Derivative(truth, x.Plus(k3, kStep_s), end_s, t0_s);
    x = x.Plus(k1, kStep_s / 6.0).Plus(k2, kStep_s / 3.0).Plus(k3, kStep_s / 3.0);
    x = x.Plus(k4, kStep_s / 6.0);
    turned_rad += kStep_s * truth.State(t_s).w_mb_b.norm();
  }
  ASSERT_GT(turned_rad, 90.0 * kRadPerDeg);  // the span contains a turn

  const MapPose end = truth.Pose(t0_s + kSpan_s);
  const Quaterniond q_im(Eigen::AngleAxisd(w.norm() * kSpan_s, w.normalized()));
  const Vector3d p_m = q_im.conjugate() * x.r - frame.r0_m();
  EXPECT_LT((p_m - end.p_mb).norm(), kPosition_m);
  const Quaterniond q_mb = q_im.conjugate() * Quaterniond(x.q).normalized();
  EXPECT_LT(Log<double>(q_mb.conjugate() * end.q_mb).norm(), kAttitude_rad);
}

TEST(TruthTrajectory, DisturbanceAgreesWithItsWaves) {
  constexpr double kStart_s = 1000.0, kDuration_s = 60.0;
  const TurbulenceScenario turbulence{.roll_rad = 1.0 * kRadPerDeg,
                                      .pitch_rad = 0.0,
                                      .heading_rad = 0.0,
                                      .speed_mps = 0.0,
                                      .height_m = 2.0};
  const Disturbance air = MakeDisturbance(turbulence, 45.0, false, 3);
  UniformSpline::Vector at;
  at << 0.0, 0.0, 150.0, 0.0, 0.0, 0.0;
  const UniformSpline path(-10.0, 2.0, std::vector<UniformSpline::Vector>(50, at));
  const LocalFrame frame(Geodetic{46.57 * kRadPerDeg, 6.52 * kRadPerDeg, 400.0});
  const TruthTrajectory truth(frame, path, air, kStart_s, kStart_s + kDuration_s);
  constexpr double kHeight_m = 1e-10, kRate_radps = 1e-7;
  for (double t = 0.0; t <= kDuration_s; t += 0.0371) {
    const TruthState state = truth.State(kStart_s + t);
    const SumOfSines::Sample height = air.height_m.At(t);
    EXPECT_NEAR(state.pose.p_mb.z(), 150.0 + height.value, kHeight_m);
    EXPECT_NEAR(state.pose.v_m.z(), height.first, 100.0 * kHeight_m);
    EXPECT_NEAR(state.w_mb_b.x(), air.roll_rad.At(t).first, kRate_radps);
  }
}

TEST(TruthTrajectory, StillPlatformSensesGravityAndEarthRate) {
  const LocalFrame frame(Geodetic{46.57 * kRadPerDeg, 6.52 * kRadPerDeg, 400.0});
  UniformSpline::Vector at;
  at << 3000.0, -2000.0, 150.0, 0.2, -0.1, 2.5;
  const UniformSpline path(-10.0, 2.0, std::vector<UniformSpline::Vector>(20, at));
  const TruthTrajectory truth(frame, path, {}, 1000.0, 1010.0);
  const TruthState state = truth.State(1004.0);
  const Eigen::Matrix3d R_bn =
      QuaternionFromRollPitchHeading({0.2, -0.1, 2.5}).toRotationMatrix().transpose();

  // The body axes follow from the definition of the angles, the Earth rate from the latitude.
  const Geodetic point = frame.ToGeodetic(at.head<3>());
  const Vector3d w_n =
      kEarthRateRadps * Vector3d(std::cos(point.lat_rad), 0.0, -std::sin(point.lat_rad));
  EXPECT_LT((state.w_ib_b - R_bn * w_n).norm(), 1e-15);
  const Vector3d g_n = frame.R_mn(at.head<3>()).transpose() * frame.Gravity(at.head<3>());
  EXPECT_LT((state.f_b + R_bn * g_n).norm(), 1e-9);  // m/s^2: rounding error of w x (w x r)
  EXPECT_NEAR(state.f_b.norm(), 9.807, 2e-3);        // normal gravity at 46.6 deg and 550 m
  EXPECT_LT(state.pose.v_m.norm(), 1e-12);
}

TEST(TruthTrajectory, TurnsAreCoordinatedAndWithinTheBank) {
  Scenario scenario = testing::SmallScenario();
  scenario.plan.turbulence = {};
  const SimulatedFlight flight = FlyWithoutPairs(scenario);
  const TruthTrajectory& truth = *flight.truth;
  double squared = 0.0, steepest_rad = 0.0;
  int count = 0;
  for (double t_s = truth.t_begin_s(); t_s < truth.t_end_s(); t_s += 0.5) {
    const NavPoint nav = truth.Nav(t_s);
    const double bank_rad = RollPitchHeading(nav.q_nb).x();
    const double lateral_rad = std::atan2(nav.f_b_mps2.y(), -nav.f_b_mps2.z());
    squared += lateral_rad * lateral_rad;
    steepest_rad = std::max(steepest_rad, std::abs(bank_rad));
    ++count;
  }
  // The turn is coordinated except for the roll-in, the Coriolis force and the crab.
  EXPECT_LT(std::sqrt(squared / count), 1.5 * kRadPerDeg);
  EXPECT_LT(steepest_rad, 25.0 * kRadPerDeg + 1e-9);  // allows for rounding
  EXPECT_GT(steepest_rad, 20.0 * kRadPerDeg);
}

TEST(TruthTrajectory, FollowsTheLinesAtTheirSpeedAndHeight) {
  const Scenario scenario = testing::SmallScenario();
  const SimulatedFlight flight = FlyWithoutPairs(scenario);
  ASSERT_EQ(flight.strips.size(), scenario.plan.lines.size());
  for (std::size_t i = 0; i < flight.strips.size(); ++i) {
    SCOPED_TRACE(i);
    const PlannedLine& line = scenario.plan.lines[i];
    const StripInterval& strip = flight.strips[i];
    const Eigen::Vector2d along = (line.end_en_m - line.start_en_m).normalized();
    const Vector3d begin_m = flight.truth->Pose(strip.t0_s).p_mb;
    const Vector3d end_m = flight.truth->Pose(strip.t1_s).p_mb;
    EXPECT_LT((begin_m.head<2>() - line.start_en_m).norm(), 0.01);
    EXPECT_LT((end_m.head<2>() - line.end_en_m).norm(), 0.01);
    const double speed_mps = (end_m - begin_m).norm() / (strip.t1_s - strip.t0_s);
    EXPECT_NEAR(speed_mps, line.speed_mps, 2.0);  // the turbulence is 1 m/s rms
    for (double t_s = strip.t0_s; t_s < strip.t1_s; t_s += 0.5) {
      const Vector3d p_m = flight.truth->Pose(t_s).p_mb;
      const Eigen::Vector2d d = p_m.head<2>() - line.start_en_m;
      EXPECT_LT(std::abs(along.x() * d.y() - along.y() * d.x()), 0.01);
      EXPECT_NEAR(p_m.z(), line.height_m, 8.0);  // four times the turbulence in height
    }
  }
  EXPECT_NEAR(flight.strips[0].t0_s, 381000.0 + 120.0, 1.0);
  EXPECT_GT(flight.truth->t_end_s(), flight.strips.back().t1_s + 60.0);
}

TEST(TruthTrajectory, StabilisedMountStaysLevel) {
  Scenario scenario = testing::SmallScenario();
  scenario.plan.stabilised_mount = true;
  const SimulatedFlight flight = FlyWithoutPairs(scenario);
  for (double t_s = flight.truth->t_begin_s(); t_s < flight.truth->t_end_s(); t_s += 0.3) {
    const Vector3d down_n = flight.truth->Nav(t_s).q_nb * Vector3d::UnitZ();
    EXPECT_LT(std::acos(std::min(1.0, down_n.z())), 0.3 * kRadPerDeg);
  }
}

TEST(TruthTrajectory, InterpolatesTheEarthBetweenTwoPlaces) {
  const SimulatedFlight flight = FlyWithoutPairs(testing::SmallScenario());
  const TruthTrajectory& truth = *flight.truth;
  for (double t_s = truth.t_begin_s(); t_s < truth.t_end_s() - 0.02; t_s += 0.7) {
    SCOPED_TRACE(t_s);
    NormalEarth a, b;
    const TruthState begin = truth.State(t_s, &a);
    truth.State(t_s + 0.02, &b);
    EXPECT_EQ(begin.w_ib_b, truth.State(t_s).w_ib_b);
    for (const double after_s : {0.0, 0.003, 0.014, 0.02}) {
      const TruthState state = truth.State(t_s + after_s),
                       between = truth.StateBetween(a, b, t_s + after_s);
      EXPECT_EQ(between.pose.p_mb, state.pose.p_mb);
      EXPECT_LE(between.pose.q_mb.angularDistance(state.pose.q_mb), 1e-10);
      EXPECT_LE((between.w_ib_b - state.w_ib_b).norm(), 1e-13);
      EXPECT_LE((between.f_b - state.f_b).norm(), 1e-9);
    }
  }
}

TEST(TruthTrajectory, ConvertsStatesToNavigationOutput) {
  const SimulatedFlight flight = FlyWithoutPairs(testing::SmallScenario());
  NormalEarth earth;
  const TruthState state = flight.truth->State(flight.truth->t_begin_s() + 3.0, &earth);
  const NavPoint point = ToNavPoint(state, earth), by_pose = ToNavPoint(state.pose, flight.frame);
  EXPECT_EQ(point.position.lat_rad, by_pose.position.lat_rad);
  EXPECT_LE(point.q_nb.angularDistance(by_pose.q_nb), 1e-14);
  EXPECT_LE((point.v_ned_mps - by_pose.v_ned_mps).norm(), 1e-13);
  EXPECT_EQ(point.f_b_mps2, state.f_b);
  EXPECT_EQ(point.w_b_radps, state.w_ib_b);
}

TEST(TruthTrajectory, RefusesTimesOutside) {
  const SimulatedFlight flight = FlyWithoutPairs(testing::SmallScenario());
  EXPECT_THROW(flight.truth->Pose(flight.truth->t_begin_s() - 1.0), InvalidInput);
  EXPECT_THROW(flight.truth->State(flight.truth->t_end_s() + 1.0), InvalidInput);
  EXPECT_THROW(flight.truth->State(std::nan("")), InvalidInput);
}

}  // namespace dn::sim_test
