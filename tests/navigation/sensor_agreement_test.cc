#include <dn/navigation/alignment.h>
#include <dn/navigation/sensor_agreement.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <utility>

#include "testing/short_flights.h"

namespace dn::navigation_test {

using testing::AircraftScenario;
using testing::DroneScenario;

Flight Fly(Scenario scenario) {
  scenario.pairs.count = 0;
  SimulateOptions options;
  options.seed = 3;
  return Simulate(scenario, options).flight;
}

/// Returns the flight with its inertial data in other axes: x_file = R^T x_body.
Flight InAxes(Flight flight, const Eigen::Matrix3d& R_file_to_body) {
  for (ImuSample& sample : flight.imu->samples) {
    sample.w_ib_b_radps = R_file_to_body.transpose() * sample.w_ib_b_radps;
    sample.f_b_mps2 = R_file_to_body.transpose() * sample.f_b_mps2;
  }
  return flight;
}

Eigen::Matrix3d Rows(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  Eigen::Matrix3d R;
  R << a.transpose(), b.transpose(), c.transpose();
  return R;
}

const Eigen::Matrix3d kFlu = Rows({1, 0, 0}, {0, -1, 0}, {0, 0, -1});
const Eigen::Matrix3d kRfu = Rows({0, 1, 0}, {1, 0, 0}, {0, 0, -1});
const Eigen::Matrix3d kBackRightUp = Rows({-1, 0, 0}, {0, 1, 0}, {0, 0, -1});
const Eigen::Matrix3d kTurned = Rows({0, -1, 0}, {1, 0, 0}, {0, 0, 1});

TEST(SensorAgreement, NamesTheAxesOfTheInertialData) {
  for (const Scenario& scenario : {DroneScenario(), AircraftScenario()}) {
    SCOPED_TRACE(scenario.name);
    const Flight flight = Fly(scenario);
    for (const Eigen::Matrix3d& R :
         {Eigen::Matrix3d(Eigen::Matrix3d::Identity()), kFlu, kRfu, kBackRightUp, kTurned}) {
      const BodyDirections found = FindBodyDirections(InAxes(flight, R));
      ASSERT_TRUE(found.course_b);
      EXPECT_GT(found.down_agreement, 0.9);
      EXPECT_GT(found.course_agreement, 0.8);
      const AxesFit fit = FitAxes(found);
      EXPECT_EQ(fit.R_turn, R);
      EXPECT_LT(fit.distance_rad, 25.0 * kRadPerDeg);
      EXPECT_EQ(FindBodyDirections(InAxes(flight, R), 3).course_b, found.course_b);
    }
  }
}

/// Returns the flight with the data of the inertial sensor multiplied by M^T.
Flight WithMistake(Flight flight, const AxesMistake& mistake) {
  for (ImuSample& sample : flight.imu->samples) {
    if (mistake.sensor != AxesMistake::Sensor::kAccel) {
      sample.w_ib_b_radps = mistake.M.transpose() * sample.w_ib_b_radps;
    }
    if (mistake.sensor != AxesMistake::Sensor::kGyro) {
      sample.f_b_mps2 = mistake.M.transpose() * sample.f_b_mps2;
    }
  }
  return flight;
}

TEST(SensorAgreementManyRuns, NamesTheMistakeInTheAxes) {
  using Sensor = AxesMistake::Sensor;
  std::vector<Eigen::Matrix3d> reflections{-Eigen::Matrix3d::Identity()};
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::Matrix3d sign = Eigen::Matrix3d::Identity(), exchange = sign;
    sign(axis, axis) = -1.0;
    exchange.row(axis).swap(exchange.row((axis + 1) % 3));
    reflections.push_back(sign);
    reflections.push_back(exchange);
  }
  // Each sensor meets both flights, and each mistake one of them.
  const Flight flights[] = {Fly(DroneScenario()), Fly(AircraftScenario())};
  std::size_t next = 0;
  for (const Sensor sensor : {Sensor::kGyro, Sensor::kAccel, Sensor::kBoth}) {
    for (const Eigen::Matrix3d& M : reflections) {
      const Flight& flight = flights[next++ % 2];
      SCOPED_TRACE(::testing::Message()
                   << "flight " << next % 2 << ", sensor " << static_cast<int>(sensor) << ", M\n"
                   << M);
      const auto found = FindAxesMistake(WithMistake(flight, {sensor, M}));
      ASSERT_TRUE(found);
      EXPECT_EQ(found->sensor, sensor);
      if (sensor == Sensor::kBoth) continue;
      EXPECT_EQ(found->M, M);
    }
  }
}

TEST(SensorAgreement, NamesTheUnitOfTheRates) {
  const Flight flight = Fly(AircraftScenario());
  for (const double scale : {kDegPerRad, kRadPerDeg}) {
    Flight scaled = flight;
    for (ImuSample& sample : scaled.imu->samples) sample.w_ib_b_radps /= scale;
    const auto found = FindAxesMistake(scaled);
    ASSERT_TRUE(found) << scale;
    EXPECT_EQ(found->sensor, AxesMistake::Sensor::kGyro);
    EXPECT_EQ(found->M(0, 0), scale);
  }
}

TEST(SensorAgreement, NamesNoMistakeInRightAxes) {
  for (const Scenario& scenario : {DroneScenario(), AircraftScenario()}) {
    SCOPED_TRACE(scenario.name);
    const Flight flight = Fly(scenario);
    EXPECT_FALSE(FindAxesMistake(flight));
    EXPECT_FALSE(FindAxesMistake(InAxes(flight, kFlu)));
    Flight late = flight;
    for (MapGnssEpoch& epoch : late.gnss->epochs) epoch.t_s += 30.0;
    EXPECT_FALSE(FindAxesMistake(late));
  }
}

TEST(SensorAgreementManyRuns, NamesTheMistakeInTheAxesOfTheFile) {
  Flight flight = InAxes(Fly(AircraftScenario()), kTurned);
  AxesMistake mistake;
  mistake.M(0, 0) = -1.0;
  flight = InAxes(WithMistake(flight, mistake), kTurned.transpose());  // as read
  flight.config.imu->read.R_imu_to_body = kTurned;
  const auto found = FindAxesMistake(flight);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->M, mistake.M);
}

// Without a course, gravity alone determines the smallest turn of the axes.
TEST(SensorAgreement, GravityAloneKeepsForward) {
  BodyDirections directions;
  directions.down_b = -Eigen::Vector3d::UnitZ();
  EXPECT_EQ(FitAxes(directions).R_turn, kFlu);
  directions.down_b = Eigen::Vector3d(0.1, -0.05, 1.0).normalized();
  EXPECT_TRUE(FitAxes(directions).R_turn.isIdentity());
}

TEST(SensorAgreement, FindsTheLagOfTheGnssTags) {
  const Flight flight = Fly(AircraftScenario());
  const auto as_is = CompareTurns(flight);
  ASSERT_TRUE(as_is);
  EXPECT_GT(as_is->correlation, 0.9);
  EXPECT_LT(std::abs(as_is->best_lag_s), 1.0);
  for (const double lag_s : {-18.0, 18.0, 5.0}) {
    Flight late = flight;
    for (MapGnssEpoch& epoch : late.gnss->epochs) epoch.t_s += lag_s;
    const auto found = CompareTurns(late);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->best_lag_s, lag_s, 0.5);
    EXPECT_GT(found->best_correlation, 0.9);
    EXPECT_LT(found->correlation, 0.8);
  }
}

TEST(SensorAgreement, LatitudeAndLongitudeExchangedTurnTheOtherWay) {
  Flight flight = Fly(AircraftScenario());
  const auto exchanged = [&](const MapGnssEpoch& epoch) {
    const Geodetic antenna = flight.frame.ToGeodetic(epoch.p_m);
    return Geodetic{antenna.lon_rad, antenna.lat_rad, antenna.h_m};
  };
  const LocalFrame frame(exchanged(flight.gnss->epochs.front()));
  for (MapGnssEpoch& epoch : flight.gnss->epochs) {
    epoch.p_m = frame.ToMap(exchanged(epoch));
    epoch.R_m_enu = frame.R_m_enu(epoch.p_m);
  }
  flight.frame = frame;
  const auto found = CompareTurns(flight);
  ASSERT_TRUE(found);
  EXPECT_LT(found->correlation, -0.9);
}

TEST(SensorAgreement, NothingIsComparedAtRest) {
  Flight flight = Fly(AircraftScenario());
  for (MapGnssEpoch& epoch : flight.gnss->epochs) epoch.p_m = flight.gnss->epochs[0].p_m;
  EXPECT_FALSE(CompareTurns(flight));
  EXPECT_FALSE(FindBodyDirections(flight).course_b);
}

// Unevenly spaced epochs give the same alignment.
TEST(SensorAgreement, AlignsFromUnevenEpochs) {
  Scenario scenario = DroneScenario();
  scenario.gnss.rate_hz = 5.0;
  scenario.pairs.count = 0;
  SimulateOptions options;
  options.seed = 3;
  SimulatedFlight sim = Simulate(scenario, options);
  std::vector<MapGnssEpoch>& epochs = sim.flight.gnss->epochs;
  std::vector<MapGnssEpoch> kept;
  for (std::size_t i = 0; i < epochs.size(); i += 3 + i % 4) kept.push_back(epochs[i]);
  epochs = kept;
  const Alignment alignment =
      Align(sim.flight, GnssTimes(sim.flight, NetworkSpan(sim.flight, false)));
  EXPECT_EQ(alignment.method, "in-flight");
  const MapPose& first = alignment.run.states.front().pose;
  const double error =
      Log(Eigen::Quaterniond(first.q_mb * sim.truth->Pose(first.t_s).q_mb.conjugate())).norm();
  EXPECT_LT(error, 5.0 * kRadPerDeg);
}

}  // namespace dn::navigation_test
