#include "tie_breaker.h"

#include <dn/sim/simulate.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "testing/short_flights.h"

namespace dn::diagnosis_internal {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

GapCause Cause(const std::string& effect, std::vector<std::string> inseparable_from = {}) {
  GapCause cause;
  cause.effect = effect;
  cause.inseparable_from = std::move(inseparable_from);
  return cause;
}

TEST(FindTies, AreBetweenFixedEffectsThatLast) {
  GapDiagnosis diagnosis;
  diagnosis.causes = {Cause("lidar_range_offset",
                            {"lidar_range_scale", "gnss_correlated_noise", "gnss_position_step"}),
                      Cause("gyro_noise_scale", {"imu_vibration"}),
                      Cause("lidar_range_scale"),
                      Cause("gnss_correlated_noise"),
                      Cause("gnss_position_step"),
                      Cause("imu_vibration")};
  diagnosis.causes[4].times.window_s = {{0.0, 1.0}};
  diagnosis.verdict.effects = {"lidar_range_offset", "gyro_noise_scale"};
  const std::vector<Tie> ties = FindTies(diagnosis);
  ASSERT_EQ(ties.size(), 1u);
  EXPECT_EQ(ties[0].named.effect, "lidar_range_offset");
  EXPECT_THAT(ties[0].competing_effects, ElementsAre("lidar_range_scale"));
}

Hypothesis Single(const std::string& effect, std::size_t block) {
  Hypothesis hypothesis;
  hypothesis.name = effect;
  hypothesis.block = block;
  hypothesis.typical = Eigen::VectorXd::Constant(1, 1.0);
  return hypothesis;
}

TEST(Separation, IsWhatTheRivalCannotTakeUp) {
  Library library;
  library.hypotheses = {Single("lidar_range_offset", 0), Single("lidar_range_scale", 1)};
  JointScore score;
  score.first = {0, 1, 2};
  score.s = Eigen::Vector2d::Zero();
  constexpr double kCorrelation = 0.6;
  score.A.resize(2, 2);
  score.A << 4.0, 2.0 * kCorrelation, 2.0 * kCorrelation, 1.0;
  score.signature2 = Eigen::Vector2d(4.0, 1.0);
  const Screen screen(library, score);
  GapCause named = Cause("lidar_range_offset");
  named.estimate = Eigen::VectorXd::Constant(1, 3.0);
  EXPECT_NEAR(Separation(screen, named, "lidar_range_scale"),
              9.0 * 4.0 * (1.0 - kCorrelation * kCorrelation), 1e-9);
  EXPECT_TRUE(std::isinf(Separation(screen, named, "lidar_time_offset")));
}

Flight TwoParallelStrips() {
  Scenario scenario = testing::AircraftScenario();
  scenario.plan.lines.pop_back();
  return Simulate(scenario, {}).flight;
}

TEST(ProposeTieBreakerManyRuns, RangesFromAnotherHeightTellAnOffsetFromAScale) {
  const Flight flight = TwoParallelStrips();
  Tie tie{Cause("lidar_range_offset"), {"lidar_range_scale"}};
  tie.named.estimate = Eigen::VectorXd::Constant(1, 0.2);
  const std::string text =
      ProposeTieBreaker(flight, *flight.reference, Eigen::Vector3d::Zero(), tie, {});
  EXPECT_THAT(text, HasSubstr("one more strip"));
  EXPECT_THAT(text, HasSubstr("would separate lidar_range_offset from lidar_range_scale"));
}

TEST(ProposeTieBreakerManyRuns, IsNoneForAnErrorTooSmallToShow) {
  const Flight flight = TwoParallelStrips();
  Tie tie{Cause("lidar_range_offset"), {"lidar_range_scale"}};
  tie.named.estimate = Eigen::VectorXd::Constant(1, 1e-5);
  EXPECT_THAT(ProposeTieBreaker(flight, *flight.reference, Eigen::Vector3d::Zero(), tie, {}),
              IsEmpty());
}

}  // namespace dn::diagnosis_internal
