#include <dn/error.h>
#include <dn/navigation/alignment.h>
#include <dn/sim/random.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "testing/expect_invalid.h"
#include "testing/short_flights.h"
#include "testing/tolerances.h"

namespace dn::navigation_test {

using testing::AircraftScenario;
using testing::DroneScenario;
using testing::kSigmas;

// Bound of the error of the last state, in sigmas of the filter.
// The alignment only starts the filter: it is good enough if the network converges from it.
constexpr double kStartHeadingRad = 5.0 * kRadPerDeg;

SimulatedFlight Fly(Scenario scenario, std::uint64_t seed) {
  scenario.pairs.count = 0;
  SimulateOptions options;
  options.seed = seed;
  return Simulate(scenario, options);
}

/// Returns the rotation about the vertical from the true to the estimated attitude.
double HeadingError(const MapPose& pose, const TruthTrajectory& truth) {
  return Log(Eigen::Quaterniond(pose.q_mb * truth.Pose(pose.t_s).q_mb.conjugate())).z();
}

void ExpectAligned(const Flight& flight, const TruthTrajectory& truth, const Alignment& alignment) {
  const MapPose& first = alignment.run.states.front().pose;
  EXPECT_LT(std::abs(HeadingError(first, truth)), kStartHeadingRad);
  const FilterState& last = alignment.run.last;
  const Eigen::Vector3d up_b = last.pose.q_mb.conjugate() * Eigen::Vector3d::UnitZ();
  const double sigma = std::sqrt(up_b.dot(last.covariance.topLeftCorner<3, 3>() * up_b));
  EXPECT_LT(sigma, 1.0 * kRadPerDeg);
  EXPECT_LT(std::abs(HeadingError(last.pose, truth)), kSigmas * sigma)
      << "sigma " << sigma * kDegPerRad << " deg";
  const double heading = RollPitchHeading(ToNavPoint(first, flight.frame).q_nb).z();
  EXPECT_NEAR(alignment.heading_rad, heading, 1e-12);
}

Alignment AlignAtGnss(const Flight& flight) {
  return Align(flight, GnssTimes(flight, NetworkSpan(flight, false)));
}

TEST(Alignment, MovingStartWithoutAnyGuess) {
  for (const std::uint64_t seed : {1, 2}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    for (const Scenario& scenario : {DroneScenario(), AircraftScenario()}) {
      SCOPED_TRACE(scenario.name);
      const SimulatedFlight sim = Fly(scenario, seed);
      const Alignment alignment = AlignAtGnss(sim.flight);
      EXPECT_EQ(alignment.method, "in-flight");
      ExpectAligned(sim.flight, *sim.truth, alignment);
    }
  }
}

/// Returns the true trajectory with a wrong heading as an initial guess.
Trajectory TurnedTruth(const SimulatedFlight& sim, double turn_rad) {
  std::vector<NavPoint> points;
  for (double t_s = sim.truth->t_begin_s(); t_s < sim.truth->t_end_s(); t_s += 1.0) {
    NavPoint point = sim.truth->Nav(t_s);
    point.q_nb = Exp(Eigen::Vector3d(0.0, 0.0, turn_rad)) * point.q_nb;
    points.push_back(point);
  }
  return Trajectory(points);
}

TEST(Alignment, SurvivesAnInitialGuessThatPointsBackwards) {
  SimulatedFlight sim = Fly(DroneScenario(), 4);
  sim.flight.initial_guess = TurnedTruth(sim, std::numbers::pi);
  const Alignment alignment = AlignAtGnss(sim.flight);
  EXPECT_NE(alignment.method, "initial guess");
  ExpectAligned(sim.flight, *sim.truth, alignment);
}

TEST(Alignment, ComparesAGoodInitialGuessWithItsOwn) {
  SimulatedFlight sim = Fly(DroneScenario(), 4);
  const int own = AlignAtGnss(sim.flight).candidates;
  sim.flight.initial_guess = TurnedTruth(sim, 0.01);
  const Alignment alignment = AlignAtGnss(sim.flight);
  EXPECT_EQ(alignment.candidates, own + 1);
  ExpectAligned(sim.flight, *sim.truth, alignment);
}

/// Returns a flight that is at rest for still_s at a heading of 70 deg, then accelerates with 2
/// m/s^2 and flies in circles.
SimulatedFlight TakeOff(const std::string& preset, double still_s, double end_s) {
  constexpr double kStepS = 1.0, kHeading = 70.0 * kRadPerDeg, kAccel = 2.0, kMaxSpeed = 15.0,
                   kTurnRadps = 0.15, kTurnAfterS = 15.0;
  SimulatedFlight sim;
  sim.frame = LocalFrame({46.5 * kRadPerDeg, 6.5 * kRadPerDeg, 400.0});
  std::vector<UniformSpline::Vector> control;
  Eigen::Vector3d p(0.0, 0.0, 0.0);
  double speed = 0.0, heading = kHeading;
  for (double t = -5.0; t < end_s + 5.0; t += kStepS) {
    control.emplace_back();
    control.back() << p, 0.02, 0.03, heading;
    if (t < still_s) continue;
    speed = std::min(kMaxSpeed, speed + kAccel * kStepS);
    if (t > still_s + kTurnAfterS) heading += kTurnRadps * kStepS;
    p += kStepS * Eigen::Vector3d(speed * std::sin(heading), speed * std::cos(heading), 1.0);
  }
  sim.truth = std::make_shared<TruthTrajectory>(sim.frame, UniformSpline(-5.0, kStepS, control),
                                                Disturbance{}, 1000.0, 1000.0 + end_s);

  Flight& flight = sim.flight;
  flight.frame = sim.frame;
  flight.config.imu.emplace().model = ImuPreset(preset);
  flight.config.gnss.emplace();
  const ImuModel& model = flight.config.imu->model;
  Random random(9, "take-off " + preset);
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero(), accel_bias = Eigen::Vector3d::Zero();
  for (const BiasProcess& process : model.gyro.processes)
    gyro_bias += process.sigma * random.Normal3();
  for (const BiasProcess& process : model.accel.processes)
    accel_bias += process.sigma * random.Normal3();
  constexpr double kDt = 0.02;
  ImuData& imu = flight.imu.emplace();
  imu.nominal_dt_s = kDt;
  for (int k = 1; k * kDt < end_s; ++k) {
    ImuSample sample{1000.0 + k * kDt, kDt};
    for (const double share : {0.5 - 0.5 / std::sqrt(3.0), 0.5 + 0.5 / std::sqrt(3.0)}) {
      const TruthState state = sim.truth->State(sample.t_s - share * kDt);
      sample.w_ib_b_radps += 0.5 * state.w_ib_b;
      sample.f_b_mps2 += 0.5 * state.f_b;
    }
    sample.w_ib_b_radps += gyro_bias + model.gyro.white / std::sqrt(kDt) * random.Normal3();
    sample.f_b_mps2 += accel_bias + model.accel.white / std::sqrt(kDt) * random.Normal3();
    imu.samples.push_back(sample);
  }
  MapGnss& gnss = flight.gnss.emplace();
  for (double t = 0.5; t < end_s - 1.0; t += 0.5) {
    MapGnssEpoch epoch;
    epoch.t_s = 1000.0 + t;
    epoch.p_m = sim.truth->Pose(epoch.t_s).p_mb +
                flight.config.gnss->sigma_enu_m.cwiseProduct(random.Normal3());
    epoch.R_m_enu = sim.frame.R_m_enu(epoch.p_m);
    gnss.epochs.push_back(epoch);
  }
  return sim;
}

TEST(Alignment, StaticStartWithMems) {
  const SimulatedFlight sim = TakeOff("apx15", 20.0, 150.0);
  const Alignment alignment = AlignAtGnss(sim.flight);
  EXPECT_EQ(alignment.method, "levelling");
  EXPECT_EQ(alignment.candidates, 8);
  ExpectAligned(sim.flight, *sim.truth, alignment);
}

TEST(Alignment, StaticStartWithNavigationGrade) {
  const SimulatedFlight sim = TakeOff("airins", 60.0, 190.0);
  const Alignment alignment = AlignAtGnss(sim.flight);
  EXPECT_EQ(alignment.method, "gyrocompass");
  ExpectAligned(sim.flight, *sim.truth, alignment);
}

// The second differences of positions with errors of metres need long spacings. The drift of these
// gyros leaves room for two.
TEST(Alignment, MovingStartWithMetresOfGnssNoiseAndAPoorGyro) {
  SimulatedFlight sim = Fly(DroneScenario(), 6);
  Random random(7, "positions");
  for (MapGnssEpoch& epoch : sim.flight.gnss->epochs) {
    epoch.p_m += 2.0 * random.Normal3();
    epoch.covariance_enu_m2 = Eigen::Matrix3d(4.0 * Eigen::Matrix3d::Identity());
  }
  BiasProcess bias;
  bias.type = BiasProcess::Type::kRandomConstant;
  bias.sigma = RadpsFromDegPerHour(1000.0);
  sim.flight.config.imu->model.gyro.processes.push_back(bias);
  const Alignment alignment = AlignAtGnss(sim.flight);
  const FilterState& last = alignment.run.last;
  const Eigen::Vector3d up_b = last.pose.q_mb.conjugate() * Eigen::Vector3d::UnitZ();
  const double sigma = std::sqrt(up_b.dot(last.covariance.topLeftCorner<3, 3>() * up_b));
  EXPECT_LT(std::abs(HeadingError(last.pose, *sim.truth)), kSigmas * sigma);
  EXPECT_LT(sigma, 10.0 * kRadPerDeg);
}

TEST(Alignment, TooFewEpochsAreNamed) {
  SimulatedFlight sim = Fly(DroneScenario(), 1);
  sim.flight.gnss->epochs.resize(2);
  testing::ExpectInvalid([&] { NetworkSpan(sim.flight, false); }, "at least three", 0);
}

TEST(Alignment, NoEpochsEvenEnoughAndNotAtRestIsSaid) {
  SimulatedFlight sim = Fly(DroneScenario(), 1);
  auto& epochs = sim.flight.gnss->epochs;
  epochs = {epochs[1], epochs[20], epochs[70]};
  testing::ExpectInvalid([&] { AlignAtGnss(sim.flight); }, "initial_guess", 0);
}

TEST(Alignment, SpanLeavesOutShortPiecesBeforeAGap) {
  SimulatedFlight sim = Fly(DroneScenario(), 3);
  ImuData& imu = *sim.flight.imu;
  const TimeInterval whole = NetworkSpan(sim.flight, false);
  imu.gaps = {{whole.t0_s + 15.0, whole.t0_s + 15.5}};
  EXPECT_EQ(NetworkSpan(sim.flight, false).t0_s, whole.t0_s);
  imu.gaps = {{whole.t0_s + 1.0, whole.t0_s + 1.2}, {whole.t1_s - 2.0, whole.t1_s - 1.5}};
  const TimeInterval useful = NetworkSpan(sim.flight, false);
  EXPECT_GE(useful.t0_s, imu.gaps.front().t_end_s);
  EXPECT_LE(useful.t1_s, imu.gaps.back().t_begin_s);
}

TEST(Alignment, SpanIncludesThePairs) {
  SimulatedFlight sim = Fly(DroneScenario(), 1);
  const TimeInterval gnss = NetworkSpan(sim.flight, true);
  LidarPair pair;
  pair.t_i_s = gnss.t0_s - 0.3;
  pair.t_j_s = gnss.t1_s + 0.2;
  sim.flight.pairs.emplace().pairs.push_back(pair);
  const TimeInterval all = NetworkSpan(sim.flight, true);
  EXPECT_EQ(all.t0_s, gnss.t0_s - 0.3);
  EXPECT_EQ(all.t1_s, gnss.t1_s + 0.2);
  EXPECT_EQ(NetworkSpan(sim.flight, false).t0_s, gnss.t0_s);
  EXPECT_EQ(GnssTimes(sim.flight, gnss).size(), GnssTimes(sim.flight, all).size());
}

}  // namespace dn::navigation_test
