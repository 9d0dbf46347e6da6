#include <dn/diagnosis/adapt.h>
#include <dn/diagnosis/diagnose.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "testing/short_flights.h"

namespace dn::diagnosis_test {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kLonger_m = 0.3;
constexpr double kFewSigmas = 5.0;

/// Returns the pairs of a simulated flight on its true trajectory, without inertial and GNSS data.
Flight PairsOnTruth(std::uint64_t seed) {
  SimulateOptions options;
  options.seed = seed;
  Flight flight = Simulate(testing::AircraftScenario(), options).flight;
  flight.trajectory = flight.reference;
  flight.config.trajectory = TrajectoryConfig();
  flight.imu.reset();
  flight.gnss.reset();
  flight.config.imu.reset();
  flight.config.gnss.reset();
  return flight;
}

GapDiagnosis Quick(const Flight& flight) {
  GapOptions options;
  options.depth = GapOptions::Depth::kQuick;
  return Diagnose(flight, options).diagnosis;
}

const DetectionLimit* Hidden(const GapDiagnosis& diagnosis, const std::string& name) {
  for (const DetectionLimit& effect : diagnosis.could_still_hide) {
    if (effect.effect == name) return &effect;
  }
  return nullptr;
}

TEST(GivenTrajectory, ShowsNoGapWhereThereIsNone) {
  const GapDiagnosis diagnosis = Quick(PairsOnTruth(1));
  EXPECT_EQ(diagnosis.verdict.kind, GapVerdictKind::kNoGap) << diagnosis.verdict.text;
  EXPECT_THAT(diagnosis.verdict.effects, IsEmpty());
  EXPECT_THAT(diagnosis.verdict.text, HasSubstr("given trajectory"));
}

TEST(GivenTrajectory, HidesTheEffectsOfItsSensorsAndItsAttitudeOffset) {
  const GapDiagnosis diagnosis = Quick(PairsOnTruth(1));
  for (const char* name : {"gnss_lever_arm", "gyro_misalignment", "trajectory_attitude_offset"}) {
    const DetectionLimit* hidden = Hidden(diagnosis, name);
    ASSERT_NE(hidden, nullptr) << name;
    EXPECT_TRUE(std::isinf(hidden->minimal_detectable)) << name;
  }
  const DetectionLimit* range = Hidden(diagnosis, "lidar_range_offset");
  ASSERT_NE(range, nullptr);
  EXPECT_TRUE(std::isfinite(range->minimal_detectable));
}

TEST(GivenTrajectory, NamesRangesThatAreTooLong) {
  Flight flight = PairsOnTruth(3);
  for (LidarPair& pair : flight.pairs->pairs) {
    pair.u_i_s += kLonger_m * pair.u_i_s.normalized();
    pair.u_j_s += kLonger_m * pair.u_j_s.normalized();
  }
  const GapDiagnosis diagnosis = Quick(flight);
  EXPECT_TRUE(diagnosis.detected);
  ASSERT_THAT(diagnosis.verdict.effects, Contains("lidar_range_offset")) << diagnosis.verdict.text;
  const GapCause cause = VerdictCauses(diagnosis).front();
  EXPECT_NEAR(cause.estimate[0], kLonger_m, kFewSigmas * cause.sigma[0]);
  EXPECT_LT(cause.sigma[0], 0.5 * kLonger_m);
}

TEST(GivenTrajectory, NeedsPairs) {
  Flight flight = PairsOnTruth(1);
  flight.pairs->pairs.resize(20);
  const GapDiagnosis diagnosis = Quick(flight);
  EXPECT_EQ(diagnosis.verdict.kind, GapVerdictKind::kUnavailable);
  EXPECT_THAT(diagnosis.verdict.text, HasSubstr("at least 100 pairs"));
}

TEST(GivenTrajectory, IsNeeded) {
  Flight flight = PairsOnTruth(1);
  flight.trajectory.reset();
  const GapDiagnosis diagnosis = Quick(flight);
  EXPECT_EQ(diagnosis.verdict.kind, GapVerdictKind::kUnavailable);
  EXPECT_THAT(diagnosis.verdict.text, HasSubstr("no trajectory"));
}

// ---- Limits -------------------------------------------------------------------------------------

TEST(Limits, NeedNoMeasuredValues) {
  SimulateOptions simulate;
  simulate.seed = 1;
  Flight plan = Simulate(testing::AircraftScenario(), simulate).flight;
  plan.imu.reset();
  plan.gnss.reset();
  GapOptions options;
  options.depth = GapOptions::Depth::kLimits;
  options.effects = {"gnss_lever_arm", "lidar_range_offset"};
  const GapDiagnosis diagnosis = Diagnose(plan, options).diagnosis;
  EXPECT_EQ(diagnosis.verdict.kind, GapVerdictKind::kUnavailable);
  EXPECT_THAT(diagnosis.verdict.text, HasSubstr("no measured value"));
  EXPECT_THAT(diagnosis.causes, IsEmpty());
  for (const char* name : {"gnss_lever_arm", "lidar_range_offset"}) {
    const DetectionLimit* hidden = Hidden(diagnosis, name);
    ASSERT_NE(hidden, nullptr) << name;
    EXPECT_GT(hidden->minimal_detectable, 0.0) << name;
    EXPECT_TRUE(std::isfinite(hidden->minimal_detectable)) << name;
  }
}

}  // namespace dn::diagnosis_test
