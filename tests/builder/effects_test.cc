#include <dn/builder/calibration_state.h>
#include <dn/effects/effect_table.h>
#include <dn/error.h>
#include <dn/rotation.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "testing/random.h"

namespace dn::builder_test {

using Eigen::Vector3d;
using Eigen::VectorXd;

/// Returns a flight whose lidar scans about y from nadir x, with pairs from 100 to 300 s.
Flight LidarFlight() {
  Flight flight;
  flight.config.lidar.emplace();
  flight.config.lidar->scan_axis_s = {0.0, 2.0, 0.0};
  flight.config.lidar->nadir_axis_s = {1.0, 0.0, 0.0};
  flight.pairs.emplace();
  LidarPair pair;
  pair.t_i_s = 300.0;
  pair.t_j_s = 100.0;
  flight.pairs->pairs.push_back(pair);
  return flight;
}

EffectAction Make(const std::string& name, const Flight& flight) {
  return FindEstimable(name)->make({flight, {.window_s = std::pair(50.0, 250.0), .t0_s = 200.0}});
}

template <class Effect>
std::shared_ptr<const Effect> As(const EffectAction& action) {
  return std::get<std::shared_ptr<const Effect>>(action);
}

ImuReading ImuAt(const std::string& name, const VectorXd& value, const Vector3d& w,
                 const Vector3d& f) {
  const Flight flight = LidarFlight();
  ImuReading reading;
  reading.t_s = 120.0;
  reading.w_b = w;
  reading.f_b = f;
  reading.J_w = reading.J_f = Eigen::Matrix3Xd::Zero(3, 9);
  reading.J_w.leftCols<3>().setIdentity();
  reading.J_f.middleCols<3>(3).setIdentity();
  As<ImuEffect>(Make(name, flight))->Correct(value, 6, &reading);
  return reading;
}

LidarReading LidarAt(const std::string& name, const VectorXd& value, double tag_s,
                     const Vector3d& u_s) {
  const Flight flight = LidarFlight();
  const double* const values = value.data();
  return Corrected({As<LidarEffect>(Make(name, flight))}, &values, tag_s, u_s);
}

TEST(Effects, EveryFixedEffectIsEstimable) {
  std::size_t fixed = 0;
  for (const EffectSpec& spec : EffectTable()) {
    const bool expected = spec.kind == EffectKind::kFixed;
    EXPECT_EQ(FindEstimable(spec.name) != nullptr, expected) << spec.name;
    fixed += expected ? 1 : 0;
  }
  EXPECT_EQ(EstimableEffects().size(), fixed);
}

TEST(Effects, EveryEstimableEffectHasAnAction) {
  const Flight flight = LidarFlight();
  for (const EstimableEffect& effect : EstimableEffects()) {
    const EffectAction action = Make(effect.name(), flight);
    const bool any = std::visit([](const auto& one) { return static_cast<bool>(one); }, action);
    EXPECT_TRUE(any) << effect.name();
  }
}

TEST(Effects, BlocksOfEveryNetworkHaveTheirConfiguredValues) {
  Flight flight = LidarFlight();
  flight.config.gnss.emplace();
  flight.config.gnss->lever_arm_b_m = {1.0, 2.0, 3.0};
  flight.config.lidar->mounting.lever_arm_b_m = {4.0, 5.0, 6.0};
  EXPECT_EQ(AssumedValue(flight, "gnss_lever_arm"), Vector3d(1.0, 2.0, 3.0));
  EXPECT_EQ(AssumedValue(flight, "lidar_lever_arm"), Vector3d(4.0, 5.0, 6.0));
  EXPECT_EQ(AssumedValue(flight, "lidar_time_offset"), VectorXd::Zero(1));
  EXPECT_EQ(AssumedValue(flight, "gyro_misalignment"), VectorXd::Zero(3));
  flight.config.gnss.reset();
  flight.config.lidar.reset();
  EXPECT_EQ(AssumedValue(flight, "gnss_lever_arm"), VectorXd::Zero(3));
  EXPECT_EQ(AssumedValue(flight, "lidar_lever_arm"), VectorXd::Zero(3));
}

class InertialDerivatives : public ::testing::TestWithParam<const char*> {};

// Checks the derivative of the corrected reading with respect to the value, and with respect to a
// change by an earlier effect.
TEST_P(InertialDerivatives, DerivativesAgreeWithDifferences) {
  constexpr double kStep = 1e-6;
  for (unsigned seed = 0; seed < 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 rng(seed);
    const Vector3d w = testing::RandomVector(rng, 0.5), f = testing::RandomVector(rng, 10.0);
    const Vector3d value = testing::RandomVector(rng, 0.05);
    const ImuReading at = ImuAt(GetParam(), value, w, f);
    for (int c = 0; c < 9; ++c) {
      const Vector3d d = kStep * Vector3d::Unit(c % 3), none = Vector3d::Zero();
      const Vector3d dw = c < 3 ? d : none, df = c >= 3 && c < 6 ? d : none, dv = c >= 6 ? d : none;
      const ImuReading plus = ImuAt(GetParam(), value + dv, w + dw, f + df);
      const ImuReading minus = ImuAt(GetParam(), value - dv, w - dw, f - df);
      const Vector3d numeric_w = (plus.w_b - minus.w_b) / (2.0 * kStep);
      const Vector3d numeric_f = (plus.f_b - minus.f_b) / (2.0 * kStep);
      EXPECT_LE((at.J_w.col(c) - numeric_w).norm(), 1e-7) << "column " << c;
      EXPECT_LE((at.J_f.col(c) - numeric_f).norm(), 1e-7) << "column " << c;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Effects, InertialDerivatives,
                         ::testing::Values("gyro_scale_factor", "accel_scale_factor",
                                           "gyro_misalignment", "accel_misalignment",
                                           "gyro_g_sensitivity"),
                         [](const auto& tested) { return std::string(tested.param); });

// Applies the definition of each effect to the true rate and force; the correction must return
// them.
TEST(Effects, TakeOutWhatTheInertialSensorsAdd) {
  const Vector3d w(0.1, -0.2, 0.3), f(1.0, 2.0, -9.8), value(1e-3, -2e-3, 3e-3);
  const Vector3d scaled_w = w + value.cwiseProduct(w), scaled_f = f + value.cwiseProduct(f);
  const Eigen::Quaterniond turn = Exp(Vector3d(-value));
  const auto expect_true = [&](const std::string& name, const Vector3d& w_measured,
                               const Vector3d& f_measured) {
    const ImuReading reading = ImuAt(name, value, w_measured, f_measured);
    EXPECT_LE((reading.w_b - w).norm() + (reading.f_b - f).norm(), 1e-13) << name;
  };
  expect_true("gyro_scale_factor", scaled_w, f);
  expect_true("accel_scale_factor", w, scaled_f);
  expect_true("gyro_misalignment", turn * w, f);
  expect_true("accel_misalignment", w, turn * f);
  expect_true("gyro_g_sensitivity", w + value.cwiseProduct(f), f);
}

TEST(Effects, ScaleFactorThatTurnsTheSensorOverIsRefused) {
  EXPECT_THROW(
      ImuAt("gyro_scale_factor", Vector3d(0.0, -1.0, 0.0), Vector3d::Ones(), Vector3d::Ones()),
      InvalidInput);
}

// The corrections undo misalignment, scale and g-sensitivity in the reverse order of the sensor,
// independent of the order of insertion.
TEST(Effects, InertialCorrectionsUndoTheOrderOfTheSensor) {
  const Flight flight = LidarFlight();
  const Vector3d w(0.1, -0.2, 0.3), f(1.0, 2.0, -9.8);
  const Vector3d turn(2e-3, 1e-3, -3e-3), scale(1e-3, -2e-3, 5e-4), g(1e-4, -2e-4, 3e-4);
  CalibrationState state;
  state.Insert({"gyro_misalignment", Make("gyro_misalignment", flight), turn});
  state.Insert({"gyro_g_sensitivity", Make("gyro_g_sensitivity", flight), g});
  state.Insert({"gyro_scale_factor", Make("gyro_scale_factor", flight), scale});
  const Vector3d turned = Exp(Vector3d(-turn)) * w;
  ImuReading reading;
  reading.w_b = turned + scale.cwiseProduct(turned) + g.cwiseProduct(f);
  reading.f_b = f;
  reading.J_w = reading.J_f = Eigen::Matrix3Xd::Zero(3, 15);
  Eigen::Index column = 6;
  for (const ImuEffectValue& one : state.ImuAt(Vector3d::Zero(), Vector3d::Zero()).effects) {
    one.effect->Correct(one.value, column, &reading);
    column += 3;
  }
  EXPECT_LE((reading.w_b - w).norm(), 1e-15);
}

class LidarDerivatives : public ::testing::TestWithParam<const char*> {};

TEST_P(LidarDerivatives, DerivativesAgreeWithDifferences) {
  constexpr double kStep = 1e-6;
  for (unsigned seed = 0; seed < 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 rng(seed);
    const Vector3d u_s = Vector3d(100.0, 3.0, 0.0) + testing::RandomVector(rng, 40.0);
    const double tag_s = 150.0 + 10.0 * seed;
    const EffectAction action = Make(GetParam(), LidarFlight());
    const int n = As<LidarEffect>(action)->components();
    const VectorXd value = testing::RandomVector(rng, 0.02).head(n);
    const LidarReading at = LidarAt(GetParam(), value, tag_s, u_s);
    for (int c = 0; c < n; ++c) {
      const VectorXd d = kStep * VectorXd::Unit(n, c);
      const LidarReading plus = LidarAt(GetParam(), value + d, tag_s, u_s);
      const LidarReading minus = LidarAt(GetParam(), value - d, tag_s, u_s);
      EXPECT_LE((at.J_u.col(c) - (plus.u_s - minus.u_s) / (2.0 * kStep)).norm(), 1e-6);
      EXPECT_NEAR(at.J_delay[c], (plus.delay_s - minus.delay_s) / (2.0 * kStep), 1e-5);
      EXPECT_LE((at.J_turn.col(c) - (plus.turn_b_rad - minus.turn_b_rad) / (2.0 * kStep)).norm(),
                1e-6);
      EXPECT_LE((at.J_arm.col(c) - (plus.arm_b_m - minus.arm_b_m) / (2.0 * kStep)).norm(), 1e-6);
    }
  }
}

// An effect transforms the derivatives of earlier effects, here of a change of the laser vector.
TEST_P(LidarDerivatives, CarriesDerivativesAlong) {
  constexpr double kStep = 1e-4;
  const Vector3d u_s(90.0, 5.0, -40.0), along(0.3, 0.5, -0.2);
  const Flight flight = LidarFlight();
  const auto effect = As<LidarEffect>(Make(GetParam(), flight));
  const VectorXd value = VectorXd::Constant(effect->components(), 0.01);
  LidarReading reading = LidarReading::Uncorrected(150.0, u_s, 1 + effect->components());
  reading.J_u.col(0) = along;
  effect->Correct(value, 1, &reading);
  const Vector3d plus = LidarAt(GetParam(), value, 150.0, u_s + kStep * along).u_s;
  const Vector3d minus = LidarAt(GetParam(), value, 150.0, u_s - kStep * along).u_s;
  EXPECT_LE((reading.J_u.col(0) - (plus - minus) / (2.0 * kStep)).norm(), 1e-8);
}

INSTANTIATE_TEST_SUITE_P(Effects, LidarDerivatives,
                         ::testing::Values("lidar_lever_arm", "lidar_time_offset",
                                           "lidar_time_drift", "lidar_range_offset",
                                           "lidar_range_scale", "lidar_angle_scale",
                                           "lidar_scan_cone", "lidar_scan_torsion",
                                           "boresight_drift", "boresight_step"),
                         [](const auto& tested) { return std::string(tested.param); });

// Applies the definition of each effect to a true laser vector; the correction must return it. The
// vector lies in the scan plane, 30 deg from nadir about the scan axis.
TEST(Effects, TakeOutWhatTheScannerAdds) {
  const Vector3d axis = Vector3d::UnitY(), nadir = Vector3d::UnitX();
  const auto beam = [&](double range_m, double angle_rad) {
    return Vector3d(range_m * (Exp(Vector3d(angle_rad * axis)) * nadir));
  };
  const auto corrected = [](const char* name, double value, const Vector3d& measured) {
    return LidarAt(name, VectorXd::Constant(1, value), 150.0, measured).u_s;
  };
  const double angle_rad = kRadPerDeg * 30.0;
  const Vector3d u_s = beam(120.0, angle_rad);
  EXPECT_LE((corrected("lidar_range_offset", 0.5, beam(120.5, angle_rad)) - u_s).norm(), 1e-12);
  EXPECT_LE((corrected("lidar_range_scale", 0.01, beam(121.2, angle_rad)) - u_s).norm(), 1e-12);
  EXPECT_LE((corrected("lidar_angle_scale", 0.01, beam(120.0, 1.01 * angle_rad)) - u_s).norm(),
            1e-12);
  const double cone_rad = 0.02;
  const Vector3d left_plane = std::cos(cone_rad) * u_s + std::sin(cone_rad) * 120.0 * axis;
  EXPECT_LE((corrected("lidar_scan_cone", cone_rad, u_s) - left_plane).norm(), 1e-12);
  const double lean_rad = 0.02 * std::sin(4.0 * angle_rad);
  const Vector3d twisted = std::cos(lean_rad) * u_s + std::sin(lean_rad) * 120.0 * axis;
  EXPECT_LE((corrected("lidar_scan_torsion", 0.02, u_s) - twisted).norm(), 1e-12);
}

// The pairs last from 100 to 300 s, so that tag = t + value (t - 100 s) and the middle is 200 s.
TEST(Effects, ClockAndMountOfTheScannerMoveInTime) {
  const Vector3d u_s(100.0, 0.0, 0.0), value(0.01, -0.02, 0.03);
  const double t_s = 260.0, drift = 1e-3;
  const LidarReading late =
      LidarAt("lidar_time_drift", VectorXd::Constant(1, drift), t_s + drift * (t_s - 100.0), u_s);
  EXPECT_NEAR(late.delay_s, drift * 160.0, 1e-12);
  EXPECT_LE((LidarAt("boresight_drift", value, t_s, u_s).turn_b_rad - 60.0 * value).norm(), 1e-12);
  EXPECT_EQ(LidarAt("boresight_step", value, 199.9, u_s).turn_b_rad, Vector3d::Zero());
  EXPECT_EQ(LidarAt("boresight_step", value, 200.1, u_s).turn_b_rad, value);
}

TEST(Effects, GnssStepsInItsWindowAndTagsAreLate) {
  const Flight flight = LidarFlight();
  const Vector3d value(0.1, 0.2, 0.3);
  for (const double tag_s : {49.0, 100.0, 251.0}) {
    GnssReading reading = GnssReading::Uncorrected(tag_s, 4);
    As<GnssEffect>(Make("gnss_time_offset", flight))->Correct(VectorXd::Zero(1), 0, &reading);
    As<GnssEffect>(Make("gnss_position_step", flight))->Correct(value, 1, &reading);
    const bool inside = tag_s == 100.0;
    EXPECT_NEAR(reading.shift_m.norm(), inside ? value.norm() : 0.0, 1e-12);
    EXPECT_LE((reading.J_shift.rightCols<3>() * value - reading.shift_m).norm(), 1e-12);
    EXPECT_EQ(reading.J_delay[0], 1.0);
  }
}

// The true lever arm is the assumed one plus the value; the true epoch is the tag less the value.
TEST(Effects, LeverArmsAndTheLidarClockAreOffByTheValue) {
  const Flight flight = LidarFlight();
  const Vector3d value(0.1, 0.2, 0.3), u_s(100.0, 5.0, 0.0);
  const LidarReading lidar = LidarAt("lidar_lever_arm", value, 150.0, u_s);
  EXPECT_EQ(lidar.arm_b_m, value);
  EXPECT_EQ(lidar.u_s, u_s);
  EXPECT_EQ(LidarAt("lidar_time_offset", VectorXd::Constant(1, 0.01), 150.0, u_s).delay_s, 0.01);
  GnssReading gnss = GnssReading::Uncorrected(100.0, 4);
  As<GnssEffect>(Make("gnss_lever_arm", flight))->Correct(value, 1, &gnss);
  EXPECT_EQ(gnss.arm_b_m, value);
  EXPECT_EQ(gnss.J_arm.rightCols<3>(), Eigen::Matrix3d::Identity());
  EXPECT_TRUE(gnss.J_arm.col(0).isZero(0.0));
}

// The epoch of a tag does not depend on the delay of the first epoch.
TEST(Effects, AnOffsetAndADriftOfTheGnssClockUndoTheTag) {
  Flight flight = LidarFlight();
  MapGnssEpoch first;
  first.t_s = 100.25;
  flight.gnss = MapGnss{{first}};
  GnssReading reading = GnssReading::Uncorrected(100.25 + 500.0 * (1.0 + 200e-6), 2);
  const auto drift = As<GnssEffect>(Make("gnss_time_drift", flight));
  As<GnssEffect>(Make("gnss_time_offset", flight))
      ->Correct(VectorXd::Constant(1, 0.25), 0, &reading);
  drift->Correct(VectorXd::Constant(1, 200e-6), 1, &reading);
  EXPECT_NEAR(reading.tag_s - reading.delay_s, 600.0, 1e-9);
  EXPECT_NEAR(reading.J_delay[1], 500.0 / (1.0 + 200e-6), 1e-9);
}

// North and east at the origin of the map, where the map axes are the ENU axes.
TEST(Effects, GravityGainsTowardNorthAndEast) {
  const Flight flight = LidarFlight();
  const Vector3d origin = Vector3d::Zero();
  const double g_mps2 = flight.frame.Gravity(origin).norm();
  const GravitationBasis tilt =
      std::get<GravitationField>(Make("gravity_tilt", flight))(origin) / g_mps2;
  const GravitationBasis more =
      std::get<GravitationField>(Make("gravity_disturbance", flight))(origin);
  EXPECT_LE((tilt.col(0) - Vector3d::UnitY()).norm(), 1e-9);
  EXPECT_LE((tilt.col(1) - Vector3d::UnitX()).norm(), 1e-9);
  EXPECT_LE((more.col(0) + Vector3d::UnitZ()).norm(), 1e-5);
}

TEST(AssumedCalibration, HasTheEffectsOfEstimateAtZeroInTheOrderOfCorrections) {
  Flight flight = LidarFlight();
  flight.config.gnss.emplace();
  flight.config.gnss->lever_arm_b_m = {1.0, 2.0, 3.0};
  flight.config.lidar->mounting.boresight_rad = {0.01, 0.0, 0.0};
  flight.config.estimate = {{"boresight", {}},         {"lidar_scan_cone", {}},
                            {"gnss_lever_arm", {}},    {"gravity_tilt", {}},
                            {"gyro_misalignment", {}}, {"accel_scale_factor", {}}};
  const CalibrationState state = AssumedCalibration(flight);
  EXPECT_EQ(state.gnss_lever_arm_b_m, Vector3d(1.0, 2.0, 3.0));
  EXPECT_LE(state.q_boresight.angularDistance(Exp(Vector3d(0.01, 0.0, 0.0))), 1e-15);
  std::vector<std::string> names;
  for (const CalibrationValue& one : state.effects) {
    names.push_back(one.name);
    EXPECT_TRUE(one.value.isZero(0.0));
  }
  EXPECT_EQ(names, (std::vector<std::string>{"accel_scale_factor", "gyro_misalignment",
                                             "gravity_tilt", "lidar_scan_cone"}));
  EXPECT_EQ(InertialEffectIndices(state), (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_EQ(PairEffectIndices(state), (std::vector<std::size_t>{3, 0, 1, 2}));
}

TEST(AssumedCalibration, RefusesWhatLacksItsTimeOrItsSensor) {
  Flight flight = LidarFlight();
  flight.config.estimate = {{"boresight_step", {}}};
  EXPECT_THROW(AssumedCalibration(flight), InvalidConfig);
  flight.config.estimate = {{"gnss_position_step", {}}};
  EXPECT_THROW(AssumedCalibration(flight), InvalidConfig);
  flight.config.lidar.reset();
  flight.config.estimate = {{"lidar_scan_cone", {}}};
  EXPECT_THROW(AssumedCalibration(flight), InvalidConfig);
}

}  // namespace dn::builder_test
