#include <dn/diagnosis/adapt.h>
#include <dn/diagnosis/diagnose.h>
#include <dn/error.h>
#include <dn/interrupted.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "diagnosis/simulate_drone.h"
#include "testing/expect_invalid.h"
#include "testing/short_flights.h"

namespace dn::diagnosis_test {

using testing::Calibration;
using testing::DroneScenario;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::SimulateDrone;

constexpr double kOffset_m = 0.15;

const Flight& OffsetDrone() {
  static const Flight flight =
      SimulateDrone("effects: [{effect: lidar_range_offset, value: 0.15}]");
  return flight;
}

GapOptions Quick() {
  GapOptions options;
  options.depth = GapOptions::Depth::kQuick;
  options.threads = 2;
  return options;
}

TEST(Diagnose, SaysThatThereIsNoGap) {
  const GapResult result = Diagnose(SimulateDrone(), Quick());
  const GapDiagnosis& diagnosis = result.diagnosis;
  EXPECT_EQ(diagnosis.verdict.kind, GapVerdictKind::kNoGap);
  EXPECT_FALSE(diagnosis.detected);
  EXPECT_GT(diagnosis.p_value, 0.05);
  EXPECT_THAT(diagnosis.verdict.effects, IsEmpty());
  EXPECT_FALSE(diagnosis.shrinkage.has_value());
  EXPECT_GT(diagnosis.validity.aa_p_value, 1e-4);
  EXPECT_EQ(diagnosis.validity.simulated_replicates, 0);
  EXPECT_FALSE(diagnosis.could_still_hide.empty());
  EXPECT_TRUE(diagnosis.user_units.boresight_inconsistency_rad.has_value());
}

TEST(Diagnose, NamesAnEffectWithItsSize) {
  const GapResult result = Diagnose(OffsetDrone(), Quick());
  const GapDiagnosis& diagnosis = result.diagnosis;
  EXPECT_EQ(diagnosis.verdict.kind, GapVerdictKind::kIdentified) << diagnosis.verdict.text;
  ASSERT_THAT(diagnosis.verdict.effects, ElementsAre("lidar_range_offset"));
  const GapCause& cause = diagnosis.causes.front();
  EXPECT_EQ(cause.effect, "lidar_range_offset");
  EXPECT_NEAR(cause.estimate[0], kOffset_m, 3.0 * cause.sigma[0]);
  ASSERT_TRUE(diagnosis.shrinkage.has_value());
  EXPECT_GT(diagnosis.shrinkage->fraction, 0.5);
  EXPECT_GT(diagnosis.shrinkage->held_out_gain_nats.value_or(0.0), 10.0);
  EXPECT_GT(diagnosis.shrinkage->share_of_reachable.value_or(0.0), 0.8);
  EXPECT_EQ(cause.held_out_gain_nats, diagnosis.shrinkage->held_out_gain_nats);
  EXPECT_FALSE(diagnosis.validity.like_replicates_p.has_value());
}

// The laser vectors may then be wrong for another reason that looks similar.
TEST(Diagnose, DoubtsASizeThatIsFarFromTheUsualOne) {
  EXPECT_FALSE(Diagnose(OffsetDrone(), Quick()).diagnosis.verdict.implausible.has_value());
  const GapResult result =
      Diagnose(SimulateDrone("effects: [{effect: lidar_range_offset, value: 1.0}]"), Quick());
  const GapVerdict& verdict = result.diagnosis.verdict;
  ASSERT_THAT(verdict.effects, ElementsAre("lidar_range_offset"));
  ASSERT_TRUE(verdict.implausible.has_value());
  EXPECT_EQ(verdict.implausible->effect, "lidar_range_offset");
  EXPECT_NEAR(verdict.implausible->typical_sizes, 50.0, 3.0);  // 0.02 m is typical
  EXPECT_EQ(verdict.implausible->discrepancy, "laser vectors by scan angle");
}

TEST(Diagnose, TheAdaptedFlightIsCalibratedAtTheTrueBoresight) {
  const SimulatedFlight flown =
      Simulate(DroneScenario("effects: [{effect: lidar_range_offset, value: 0.15}]"), {});
  const GapResult result = Diagnose(flown.flight, Quick());
  Flight adapted = flown.flight;
  adapted.config = result.adapted;
  const Calibration calibration(adapted);
  const Eigen::Vector3d error_rad = calibration.BoresightError(flown.boresight_rad);
  const Eigen::Vector3d sigma_rad = calibration.boresight.sigma_rad();
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_LT(std::abs(error_rad[axis]), 4.0 * sigma_rad[axis]) << axis;
  }
  EXPECT_EQ(calibration.solution.CheckedBoresight().verdict, calibration.boresight.verdict);
}

TEST(Diagnose, SimulatesTwinsThatLookLikeTheFlight) {
  GapOptions options = Quick();
  options.depth = GapOptions::Depth::kFull;
  const GapDiagnosis diagnosis = Diagnose(OffsetDrone(), options).diagnosis;
  EXPECT_EQ(diagnosis.validity.simulated_replicates, 16);
  EXPECT_GT(diagnosis.validity.full_against_linear_p.value_or(0.0), 0.002);
  EXPECT_GT(diagnosis.validity.like_replicates_p.value_or(0.0), 0.01);
  const bool band =
      std::any_of(diagnosis.fingerprint.begin(), diagnosis.fingerprint.end(),
                  [](const FingerprintValue& v) { return v.simulated_mean.has_value(); });
  EXPECT_TRUE(band);
}

TEST(Diagnose, IsInterrupted) {
  GapOptions options = Quick();
  options.interrupted = [] { return true; };
  EXPECT_THROW(Diagnose(OffsetDrone(), options), Interrupted);
}

TEST(Diagnose, RefusesEffectsThatAreNone) {
  GapOptions options;
  options.effects = {"lidar_range"};
  EXPECT_THROW(options.Validate(), InvalidConfig);
  options.effects.clear();
  options.alpha = 1.5;
  EXPECT_THROW(options.Validate(), InvalidConfig);
}

}  // namespace dn::diagnosis_test
