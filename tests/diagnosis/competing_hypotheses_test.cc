#include "competing_hypotheses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace dn::diagnosis_internal {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

HypothesisEvidence WithEvidence(const std::string& name, double nats, bool physical = true) {
  HypothesisEvidence effect;
  effect.name = name;
  if (physical) effect.id = EffectId::kGnssLeverArm;
  effect.log_evidence = nats;
  return effect;
}

constexpr HypothesisPrior kPrior{.outside = 0.2, .unseen_nats = 5.0};

CompetingHypotheses Competing(const std::string& effect,
                              const std::vector<HypothesisEvidence>& competing) {
  return MakeCompetingHypotheses(effect, competing, kPrior);
}

GapCause Cause(const std::string& effect) {
  GapCause cause;
  cause.effect = effect;
  return cause;
}

std::vector<std::string> Names(const std::vector<GapCause>& causes) {
  std::vector<std::string> names;
  for (const GapCause& cause : causes) names.push_back(cause.effect);
  return names;
}

TEST(FillCauses, PutsTheNamedFirstAndWhatHasNoNameApart) {
  const std::vector<HypothesisEvidence> screened{WithEvidence("b", 30.0), WithEvidence("a", 29.0),
                                                 WithEvidence("strips", 20.0, false),
                                                 WithEvidence("c", 0.0)};
  const std::vector<CompetingHypotheses> slots{
      Competing("a", {WithEvidence("a", 25.0), WithEvidence("d", 24.5), WithEvidence("c", 0.0)})};
  GapDiagnosis diagnosis;
  FillCauses(screened, slots, {Cause("a")}, &diagnosis);
  EXPECT_THAT(Names(diagnosis.causes), ElementsAre("a", "b", "c"));
  ASSERT_EQ(diagnosis.discrepancies.size(), 1u);
  EXPECT_EQ(diagnosis.discrepancies[0].name, "strips");
  EXPECT_EQ(diagnosis.causes[0].log_evidence, 25.0);
  EXPECT_EQ(diagnosis.causes[0].posterior, slots[0].posterior.own[0]);
  EXPECT_NEAR(diagnosis.outside_posterior, slots[0].posterior.outside, 1e-12);
  EXPECT_THAT(diagnosis.causes[0].inseparable_from, ElementsAre("d"));
}

TEST(FillCauses, AddsTheProbabilitiesOfAllSlots) {
  const std::vector<HypothesisEvidence> screened{WithEvidence("a", 9.0), WithEvidence("b", 9.0)};
  const std::vector<CompetingHypotheses> slots{Competing("x", screened), Competing("y", screened)};
  GapDiagnosis diagnosis;
  FillCauses(screened, slots, {}, &diagnosis);
  const double one = slots[0].posterior.own[0];
  EXPECT_NEAR(diagnosis.causes[0].posterior, 1.0 - (1.0 - one) * (1.0 - one), 1e-12);
}

TEST(SetProbabilities, LeavesRoomForWhatTheTableLacks) {
  const auto causes = [](double rest_nats) {
    HypothesisPrior prior = kPrior;
    prior.rest_nats = rest_nats;
    GapDiagnosis diagnosis;
    FillCauses(
        {WithEvidence("a", 60.0)},
        {MakeCompetingHypotheses("a", {WithEvidence("a", 60.0), WithEvidence("b", 58.0)}, prior)},
        {Cause("a")}, &diagnosis);
    return diagnosis;
  };
  const GapDiagnosis alone = causes(0.0), with_rest = causes(20.0);
  EXPECT_NEAR(alone.causes[0].posterior, 0.87, 0.01);
  EXPECT_NEAR(alone.outside_posterior, 0.015, 0.01);
  EXPECT_LT(with_rest.causes[0].posterior, 0.55);
  EXPECT_GT(with_rest.outside_posterior, 0.999) << "the rest is not in the library";
}

class Decided : public ::testing::Test {
 protected:
  const std::vector<CompetingHypotheses> clear_{
      Competing("a", {WithEvidence("a", 30.0), WithEvidence("b", 0.0)})};
  const std::vector<CompetingHypotheses> tied_{
      Competing("a", {WithEvidence("a", 30.0), WithEvidence("b", 30.0)})};
};

TEST_F(Decided, NamesWhatExplainsTheGap) {
  const GapVerdict verdict = Decide({.detected = true}, {"a"}, clear_);
  EXPECT_EQ(verdict.kind, GapVerdictKind::kIdentified);
  EXPECT_THAT(verdict.effects, ElementsAre("a"));
  EXPECT_THAT(verdict.credible_set, ElementsAre("a"));
  EXPECT_FALSE(verdict.unknown);
}

TEST_F(Decided, NamesAGroupWhereItCannotTell) {
  const GapVerdict verdict = Decide({.detected = true}, {"a"}, tied_);
  EXPECT_EQ(verdict.kind, GapVerdictKind::kGroup);
  EXPECT_THAT(verdict.credible_set, UnorderedElementsAre("a", "b"));
}

TEST_F(Decided, SaysThatSomethingIsLeft) {
  const GapVerdict verdict = Decide({.detected = true, .gap_remains = true}, {"a"}, clear_);
  EXPECT_EQ(verdict.kind, GapVerdictKind::kPartial);
  EXPECT_TRUE(verdict.unknown);
  EXPECT_THAT(verdict.effects, ElementsAre("a"));
}

TEST_F(Decided, NamesNothingWhereADiscrepancyIsBetter) {
  const GapVerdict verdict =
      Decide({.detected = true, .discrepancy_is_better = true}, {"a"}, clear_);
  EXPECT_EQ(verdict.kind, GapVerdictKind::kUnknown);
  EXPECT_THAT(verdict.effects, IsEmpty());
  EXPECT_THAT(verdict.credible_set, ElementsAre("a"));
}

TEST_F(Decided, NamesNothingWhereADiscrepancyIsLikelier) {
  HypothesisEvidence strips = WithEvidence("strips", 33.0);
  strips.id.reset();
  const std::vector<CompetingHypotheses> doubtful{
      Competing("a", {WithEvidence("a", 30.0), strips})};
  ASSERT_GT(doubtful[0].discrepancy_posterior, 0.5);
  const GapVerdict alone = Decide({.detected = true}, {"a"}, doubtful);
  EXPECT_EQ(alone.kind, GapVerdictKind::kUnknown);
  EXPECT_THAT(alone.effects, IsEmpty());
  EXPECT_THAT(alone.credible_set, ElementsAre("a"));
  EXPECT_TRUE(alone.unknown);

  const GapVerdict beside = Decide({.detected = true}, {"b", "a"}, {clear_[0], doubtful[0]});
  EXPECT_EQ(beside.kind, GapVerdictKind::kPartial);
  EXPECT_THAT(beside.effects, ElementsAre("b", "a"));

  strips.log_evidence = 27.0;
  const std::vector<CompetingHypotheses> likely{Competing("a", {WithEvidence("a", 30.0), strips})};
  EXPECT_EQ(Decide({.detected = true}, {"a"}, likely).kind, GapVerdictKind::kIdentified);
}

// An effect of many times its typical size has less evidence than a discrepancy of typical size,
// but fits better.
TEST_F(Decided, KeepsANameThatFitsBetterThanADiscrepancy) {
  HypothesisEvidence drift = WithEvidence("a", 30.0), heading = WithEvidence("heading", 33.0);
  heading.id.reset();
  heading.statistic = 90.0;
  drift.statistic = 100.0;
  EXPECT_EQ(Decide({.detected = true}, {"a"}, {Competing("a", {heading, drift})}).kind,
            GapVerdictKind::kIdentified);
  drift.statistic = 80.0;
  EXPECT_EQ(Decide({.detected = true}, {"a"}, {Competing("a", {heading, drift})}).kind,
            GapVerdictKind::kUnknown);
}

TEST_F(Decided, SaysNothingOfAFlightWithoutAGap) {
  const GapVerdict verdict = Decide({}, {}, clear_);
  EXPECT_EQ(verdict.kind, GapVerdictKind::kNoGap);
  EXPECT_THAT(verdict.credible_set, IsEmpty());
}

}  // namespace dn::diagnosis_internal
