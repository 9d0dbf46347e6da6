#include <dn/diagnosis/gap_output.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>

#include "diagnosis/some_diagnosis.h"

namespace dn::diagnosis_test {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using testing::LeverArmDiagnosis;
using ::testing::Not;

constexpr double kRoundings = 1e-12;

TEST(GapJson, HoldsTheGapInItsUnits) {
  const Json json = GapJson(LeverArmDiagnosis());
  EXPECT_EQ(json["schema"], "dn.gap/1");
  EXPECT_EQ(json["flight"], "somewhere");
  const Json& gap = json["gap"];
  EXPECT_EQ(gap["detected"], true);
  EXPECT_EQ(gap["p_value"], 0.002);
  EXPECT_EQ(gap["size_nats_per_obs"]["value"], 0.03);
  EXPECT_EQ(gap["size_nats_per_obs"]["null_interval_95"], Json({-0.001, 0.004}));
  EXPECT_EQ(gap["size_nats_per_obs"]["upper_limit_95"], 0.036);
  EXPECT_EQ(gap["user_units"]["p2p_excess_mm"], 12.0);
  EXPECT_TRUE(gap["user_units"]["gnss_excess_mm"].is_null());
  EXPECT_NEAR(gap["user_units"]["boresight_inconsistency_mdeg"].get<double>(), 3.1, kRoundings);
  EXPECT_NEAR(gap["user_units"]["gh_minus_dn_mdeg"][2].get<double>(), 3.0, kRoundings);
  EXPECT_EQ(json["where"][1]["quantity"], "position up");
  EXPECT_EQ(json["where"][0]["p_adjusted"], 0.001);
}

TEST(GapJson, HoldsEveryCause) {
  const Json causes = GapJson(LeverArmDiagnosis())["causes"];
  ASSERT_EQ(causes.size(), 3u);
  const Json& arm = causes[0];
  EXPECT_EQ(arm["effect"], "gnss_lever_arm");
  EXPECT_EQ(arm["log_evidence"], 45.25);
  EXPECT_EQ(arm["posterior"], 0.97);
  EXPECT_EQ(arm["estimate"], Json({0.1, 0.0, -0.05}));
  EXPECT_EQ(arm["sigma"], Json({0.004, 0.004, 0.006}));
  EXPECT_EQ(arm["unit"], "m");
  EXPECT_NEAR(arm["boresight_damage_mdeg"][2].get<double>(), 14.0, kRoundings);
  EXPECT_EQ(arm["inseparable_from"], Json::array({"lidar_lever_arm"}));
  EXPECT_EQ(arm["held_out_gain_nats"], 12.5);
  EXPECT_TRUE(arm["shrinkage"].is_null());
  EXPECT_FALSE(arm.contains("t0_s"));
  EXPECT_EQ(causes[1]["t0_s"], 381500.0);
}

TEST(GapJson, HoldsVerdictAndShrinkage) {
  const Json json = GapJson(LeverArmDiagnosis());
  EXPECT_EQ(json["discrepancies"][0]["name"], "laser vectors by strip");
  EXPECT_EQ(json["discrepancies"][0]["log_evidence"], 3.5);
  EXPECT_FALSE(json["discrepancies"][0].contains("period_s"));
  EXPECT_EQ(json["discrepancies"][1]["posterior"], 0.01);
  EXPECT_EQ(json["discrepancies"][1]["period_s"], 42.4);
  EXPECT_FALSE(json["discrepancies"][1].contains("tau_s"));
  EXPECT_EQ(json["discrepancies"][2]["tau_s"], 50.0);
  EXPECT_EQ(json["verdict"]["kind"], "identified");
  EXPECT_EQ(json["verdict"]["effects"], Json::array({"gnss_lever_arm"}));
  EXPECT_EQ(json["verdict"]["unknown"], false);
  EXPECT_TRUE(json["verdict"]["tie_breaker"].is_null());
  const Json& shrinkage = json["shrinkage"];
  EXPECT_EQ(shrinkage["fraction"], 0.97);
  EXPECT_EQ(shrinkage["interval_95"], Json({0.9, 0.99}));
  EXPECT_EQ(shrinkage["p_before"], 0.002);
  EXPECT_EQ(shrinkage["p_after"], 0.41);
  EXPECT_EQ(shrinkage["size_after"], 0.001);
  EXPECT_EQ(shrinkage["p2p_mm_before"], 92.0);
  EXPECT_TRUE(shrinkage["gnss_mm_after"].is_null());
  EXPECT_NEAR(shrinkage["boresight_after_deg"][0].get<double>(), 0.203, kRoundings);
  EXPECT_NEAR(shrinkage["boresight_sigma_after_deg"][2].get<double>(), 0.0035, kRoundings);
}

TEST(GapJson, WritesNullWhereThereIsNoNumber) {
  GapDiagnosis d = LeverArmDiagnosis();
  d.shrinkage.reset();
  const Json json = GapJson(d);
  EXPECT_TRUE(json["shrinkage"].is_null());
  const Json& cone = json["could_still_hide"][2];
  EXPECT_TRUE(cone["minimal_detectable"].is_null());
  EXPECT_TRUE(cone["minimal_identifiable"].is_null());
  EXPECT_TRUE(cone["boresight_damage_mdeg"][0].is_null());
  EXPECT_EQ(cone["inseparable_from"], Json::array({"boresight"}));
  EXPECT_EQ(json["could_still_hide"][0]["minimal_identifiable"], 60.0);
  d.could_still_hide[0].detectable_by_component =
      Eigen::Vector3d(0.5, std::numeric_limits<double>::infinity(), 2.0);
  EXPECT_EQ(GapJson(d)["could_still_hide"][0]["detectable_by_component"],
            Json({0.5, nullptr, 2.0}));
  EXPECT_EQ(json["fingerprint"][0]["twin_mean"], 4.8);
  EXPECT_TRUE(json["fingerprint"][1]["twin_mean"].is_null());
  EXPECT_EQ(json["validity"]["full_twins"], 24);
  EXPECT_EQ(json["timings_s"]["twins"], 12.5);
}

TEST(VerdictSentence, NamesEffectSizeHarmAndKey) {
  EXPECT_THAT(VerdictSentence(LeverArmDiagnosis()),
              AllOf(HasSubstr("gnss_lever_arm of 0.1 +- 0.004, 0 +- 0.004, -0.05 +- 0.006 m"),
                    HasSubstr("moves the boresight (roll, pitch, yaw) by 3, -4, 14 mdeg"),
                    HasSubstr("add gnss_lever_arm to estimate in flight.yaml"),
                    HasSubstr("closes 97 % of the gap (90 to 99)")));
}

TEST(VerdictSentence, OfARandomEffectSaysHowTheBoresightMovesWithIt) {
  GapDiagnosis d = LeverArmDiagnosis();
  GapCause noise;
  noise.effect = "gnss_correlated_noise";
  noise.estimate = Eigen::Vector4d(0.05, 0.05, 0.05, 60.0);
  noise.sigma = Eigen::Vector4d(0.003, 0.003, 0.003, std::nan(""));
  d.causes = {noise};
  d.verdict.effects = {noise.effect};
  EXPECT_THAT(
      VerdictSentence(d),
      AllOf(HasSubstr("gnss_correlated_noise of sigma 0.05 +- 0.003 m, tau 60 s: state it"),
            HasSubstr("(90 to 99) and moves the boresight (roll, pitch, yaw) by 3, -4, 14")));
  noise.estimate[2] = 0.1;
  d.causes = {noise};
  EXPECT_THAT(VerdictSentence(d), HasSubstr("of sigma 0.05 +- 0.003 m, sigma up 0.1 +- 0.003 m"));
}

TEST(VerdictSentence, OnAGivenTrajectoryAsksForACorrection) {
  GapDiagnosis d = LeverArmDiagnosis();
  d.trajectory_given = true;
  EXPECT_THAT(VerdictSentence(d),
              AllOf(HasSubstr("or estimate gnss_lever_arm with the dynamic network"),
                    Not(HasSubstr("to estimate in flight.yaml"))));
  EXPECT_EQ(GapJson(d)["trajectory_given"], true);
}

TEST(VerdictSentence, ALowerEndBelowZeroHasNoDigits) {
  GapDiagnosis d = LeverArmDiagnosis();
  d.shrinkage->interval_low = -1e9;
  EXPECT_THAT(VerdictSentence(d), HasSubstr("closes 97 % of the gap (below 0 to 99)"));
}

TEST(VerdictSentence, SaysTheKeyOfEachOfSeveralEffects) {
  GapDiagnosis d = LeverArmDiagnosis();
  d.verdict.effects = {"boresight_step", "gyro_bias_process"};
  EXPECT_THAT(
      VerdictSentence(d),
      AllOf(
          HasSubstr("boresight_step of 0.01 +- 0.001, 0 +- 0.001, 0 +- 0.002 deg from 381500 s on"),
          HasSubstr("add {unknown: boresight_step, t0_s: 381500} to estimate"),
          HasSubstr("gyro_bias_process of sigma 0.3 +- 0.05 deg/h, tau 90 +- 30 s"),
          HasSubstr("state it in imu.gyro.processes of flight.yaml")));
}

TEST(VerdictSentence, SaysThatASizeIsFarFromTheUsualOne) {
  GapDiagnosis d = LeverArmDiagnosis();
  EXPECT_THAT(VerdictSentence(d), Not(HasSubstr("typical size")));
  d.verdict.implausible = {"gnss_lever_arm", 43.7, "GNSS positions by time"};
  EXPECT_THAT(VerdictSentence(d),
              HasSubstr("gnss_lever_arm has 44 times its typical size, and GNSS positions by time "
                        "fits the data almost equally well"));
}

TEST(VerdictSentence, OfAGroupSaysWhatItCouldBeAndWhatToFly) {
  GapDiagnosis d = LeverArmDiagnosis();
  d.verdict.kind = GapVerdictKind::kGroup;
  d.verdict.credible_set = {"gnss_lever_arm", "gnss_time_offset"};
  d.verdict.tie_breaker = "a strip at another speed would separate them";
  EXPECT_THAT(VerdictSentence(d),
              AllOf(HasSubstr("cannot separate it from gnss_time_offset or lidar_lever_arm"),
                    HasSubstr("; a strip at another speed")));
}

TEST(VerdictSentence, OfWhatHasNoNameSaysWhere) {
  GapDiagnosis d = LeverArmDiagnosis();
  d.verdict.kind = GapVerdictKind::kPartial;
  EXPECT_THAT(VerdictSentence(d),
              AllOf(HasSubstr("gnss_lever_arm of"), HasSubstr("explains the rest of the gap"),
                    HasSubstr("lidar p2p, strip pair 1-2, scan angle 20..30 deg")));
  d.verdict.kind = GapVerdictKind::kUnknown;
  d.verdict.effects.clear();
  EXPECT_THAT(VerdictSentence(d),
              AllOf(HasSubstr("p = 0.002"), HasSubstr("strip pair 1-2"),
                    HasSubstr("do not use the boresight"), Not(HasSubstr("gnss_lever_arm")),
                    Not(HasSubstr("best description"))));
  d.discrepancies.back().posterior = 0.9;
  EXPECT_THAT(VerdictSentence(d),
              HasSubstr("; the best description is boresight that settles, tau 50 s"));
}

TEST(VerdictSentence, OfNoGapSaysWhatCouldHide) {
  GapDiagnosis d = LeverArmDiagnosis();
  d.verdict.kind = GapVerdictKind::kNoGap;
  d.verdict.effects.clear();
  EXPECT_THAT(VerdictSentence(d), AllOf(HasSubstr("at most 0.036 nats"),
                                        HasSubstr("undetectable at any size: lidar_scan_cone")));
  d.could_still_hide.pop_back();
  EXPECT_THAT(VerdictSentence(d),
              HasSubstr("gnss_time_offset below 0.0012 s is undetectable, and can shift the "
                        "boresight (roll, pitch, yaw) by up to 0.2, 7, 5.9 mdeg"));
}

TEST(VerdictSentence, OfNoGapTellsTheComponentsOfAVector) {
  GapDiagnosis d = LeverArmDiagnosis();
  d.verdict.kind = GapVerdictKind::kNoGap;
  d.verdict.effects.clear();
  DetectionLimit hidden;
  hidden.effect = "gyro_g_sensitivity";
  hidden.unit = "deg/h/g";
  hidden.minimal_detectable = 0.05;
  hidden.detectable_by_component =
      Eigen::Vector3d(1.2, std::numeric_limits<double>::infinity(), 0.052);
  d.could_still_hide = {hidden};
  EXPECT_THAT(VerdictSentence(d), HasSubstr("gyro_g_sensitivity below 1.2, any, 0.052 deg/h/g "
                                            "(x, y, z alone) is undetectable"));
}

TEST(VerdictSentence, OfAFlightThatCannotCarryTheDiagnosisSaysWhy) {
  GapDiagnosis d;
  d.verdict.kind = GapVerdictKind::kUnavailable;
  d.validity.notes = {"two parallel strips"};
  d.verdict.tie_breaker = "fly a cross strip";
  EXPECT_EQ(VerdictSentence(d),
            "the flight cannot be diagnosed: two parallel strips; fly a cross strip");
}

TEST(VerdictSentence, OfAFaultAsksForARepair) {
  GapDiagnosis d;
  d.verdict.kind = GapVerdictKind::kIdentified;
  d.verdict.effects = {"imu_gap"};
  GapCause gap;
  gap.effect = "imu_gap";
  gap.times.window_s = {10.0, 12.0};
  d.causes = {gap};
  EXPECT_EQ(
      VerdictSentence(d),
      "the model lacks imu_gap from 10 to 12 s: no key of flight.yaml models it, so repair the "
      "data");
}

// ---- Sentences that must not contradict themselves ----------------------------------------------

GapDiagnosis WithVerdict(GapVerdictKind kind) {
  GapDiagnosis d = LeverArmDiagnosis();
  d.verdict.kind = kind;
  d.verdict.unknown = kind == GapVerdictKind::kPartial || kind == GapVerdictKind::kUnknown;
  if (kind == GapVerdictKind::kUnknown || kind == GapVerdictKind::kNoGap) {
    d.verdict.effects.clear();
    d.shrinkage.reset();
  }
  return d;
}

GapDiagnosis WithoutPairs(GapDiagnosis d) {
  for (GapCause& cause : d.causes) cause.boresight_rad.setZero();
  for (DetectionLimit& effect : d.could_still_hide) effect.boresight_rad.setZero();
  if (!d.shrinkage) return d;
  for (GapState* state : {&d.shrinkage->before, &d.shrinkage->after}) {
    state->boresight_rad.reset();
    state->p2p_m.reset();
  }
  return d;
}

/// Returns diagnoses of one kind: closed by different shares, with and without a visible rest,
/// within and beyond tolerances.
std::vector<GapDiagnosis> Variants(GapVerdictKind kind) {
  std::vector<GapDiagnosis> all;
  for (const double closed : {-0.2, 0.0, 0.4, 0.97, 0.9996, 0.999999, 1.0}) {
    for (const double p_after : {0.001, 0.4}) {
      for (const bool discrepancy : {false, true}) {
        for (const double prior_sigmas : {0.0, 1.5, 12.0}) {
          GapDiagnosis d = WithVerdict(kind);
          d.with_tolerances = prior_sigmas > 0.0;
          if (prior_sigmas > 0.0) d.causes[0].prior_sigmas = prior_sigmas;
          if (d.shrinkage) {
            d.shrinkage->fraction = closed;
            d.shrinkage->interval_low = closed - 1e-5;
            d.shrinkage->interval_high = closed + 1e-6;
            d.shrinkage->after.p_value = p_after;
            if (discrepancy) d.shrinkage->rest = d.discrepancies[1];
          }
          all.push_back(d);
          all.push_back(WithoutPairs(d));
        }
      }
    }
  }
  return all;
}

constexpr GapVerdictKind kKinds[] = {GapVerdictKind::kIdentified, GapVerdictKind::kGroup,
                                     GapVerdictKind::kPartial, GapVerdictKind::kUnknown,
                                     GapVerdictKind::kNoGap};

TEST(VerdictSentences, SpeakOfTheBoresightOnlyWithPairs) {
  for (const GapVerdictKind kind : kKinds) {
    for (const GapDiagnosis& d : Variants(kind)) {
      const bool pairs = !d.could_still_hide.front().boresight_rad.isZero(0.0);
      const std::string text = VerdictSentence(d);
      SCOPED_TRACE(text);
      if (!pairs) {
        EXPECT_THAT(text, Not(HasSubstr("boresight")));
      }
      if (kind != GapVerdictKind::kUnknown) continue;
      EXPECT_THAT(text,
                  HasSubstr(pairs ? "do not use the boresight" : "do not use the trajectory"));
    }
  }
}

TEST(VerdictSentences, RoundNoShareToTheWhole) {
  for (const GapVerdictKind kind : kKinds) {
    for (const GapDiagnosis& d : Variants(kind)) {
      const std::string text = VerdictSentence(d);
      SCOPED_TRACE(text);
      const bool whole = d.shrinkage && d.shrinkage->fraction == 1.0;
      if (!whole) {
        EXPECT_THAT(text, Not(HasSubstr("closes 100 %")));
      }
      EXPECT_THAT(text, Not(AnyOf(HasSubstr("closes -"), HasSubstr("closes 0 %"))));
    }
  }
}

TEST(VerdictSentences, SayInWhatTheRestShows) {
  for (const GapDiagnosis& d : Variants(GapVerdictKind::kPartial)) {
    const std::string text = VerdictSentence(d);
    SCOPED_TRACE(text);
    EXPECT_THAT(text, Not(HasSubstr("is reliable")));
    const bool significant = d.shrinkage->after.p_value < 0.05;
    EXPECT_EQ(text.find("significant (p = 0.001; 0.001 nats per observation)") < text.size(),
              significant);
    EXPECT_EQ(text.find("is small, but significant") < text.size(),
              significant && d.shrinkage->fraction > 0.9);
    EXPECT_EQ(text.find("resembles GNSS oscillation, 42 s") < text.size(),
              d.shrinkage->rest.has_value());
  }
  GapDiagnosis d = WithVerdict(GapVerdictKind::kPartial);
  d.validity.like_replicates_p = 0.001;
  EXPECT_THAT(VerdictSentence(d), HasSubstr("which shows in simulated flights with the same"));
}

TEST(VerdictSentences, SayWhetherTheNamedEffectsAreTolerances) {
  for (const GapVerdictKind kind :
       {GapVerdictKind::kIdentified, GapVerdictKind::kGroup, GapVerdictKind::kPartial}) {
    SCOPED_TRACE(Word(kind));
    GapDiagnosis d = WithVerdict(kind);
    d.causes[0].inseparable_from.clear();
    d.causes[0].prior_sigmas = 2.0;
    EXPECT_THAT(VerdictSentence(d), AllOf(HasSubstr("(2 times its usual sigma, a tolerance)"),
                                          HasSubstr("within the tolerance of the sensors")));
    d.causes[0].prior_sigmas = 12.0;
    EXPECT_THAT(VerdictSentence(d), AllOf(HasSubstr("(12 times its usual sigma, a fault)"),
                                          Not(HasSubstr("within the tolerance"))));
  }
}

TEST(VerdictSentences, CallTheResultReliableWhereAllExplanationsAreTolerances) {
  GapDiagnosis d = WithVerdict(GapVerdictKind::kNoGap);
  d.with_tolerances = true;
  EXPECT_THAT(VerdictSentence(d), HasSubstr("so that the boresight is reliable"));
  d = WithVerdict(GapVerdictKind::kGroup);
  d.causes[0].prior_sigmas = 2.0;
  d.causes[0].inseparable_from.clear();
  d.verdict.credible_set = {"gnss_lever_arm", "boresight_step"};
  EXPECT_THAT(VerdictSentence(d), AllOf(HasSubstr("others would not"), Not(HasSubstr("reliable"))));
  d.causes[1].prior_sigmas = 1.0;
  EXPECT_THAT(VerdictSentence(d), HasSubstr("so that the boresight is reliable"));
  d.trajectory_given = true;
  EXPECT_THAT(VerdictSentence(d), Not(HasSubstr("reliable")));
}

TEST(VerdictSentences, SayWhyMuchEvidenceIsNotEnough) {
  GapDiagnosis d = WithVerdict(GapVerdictKind::kUnknown);
  d.causes[0].log_evidence = 122565.0;
  d.causes[0].posterior = 0.0;
  d.discrepancies[0].log_evidence = 123000.0;
  d.discrepancies[0].posterior = 0.99;
  constexpr const char* kLess = "435.0 nats less than laser vectors by strip";
  EXPECT_THAT(VerdictSentence(d),
              AllOf(HasSubstr("best description is laser vectors by strip"), HasSubstr(kLess)));
  EXPECT_THAT(GapSummary(d), HasSubstr(kLess));

  d = WithVerdict(GapVerdictKind::kIdentified);
  d.causes[1].log_evidence = 122565.0;
  d.causes[1].left_nats = -0.3;
  EXPECT_THAT(GapSummary(d), HasSubstr("; -0.3 nats are left with the named effects"));
  EXPECT_EQ(GapJson(d)["causes"][1]["left_nats"], -0.3);
}

TEST(VerdictSentences, GiveTheRivalOfADoubtfulName) {
  GapDiagnosis d = WithVerdict(GapVerdictKind::kIdentified);
  d.causes[0].posterior = 0.6;
  d.discrepancies[0].posterior = 0.4;
  EXPECT_THAT(VerdictSentence(d), HasSubstr("the probability of gnss_lever_arm is 0.60, that of "
                                            "laser vectors by strip 0.40"));
}

TEST(VerdictSentences, LeaveOutSizesThatWereNotMeasured) {
  GapDiagnosis d = WithVerdict(GapVerdictKind::kIdentified);
  d.causes[0].effect = d.verdict.effects[0] = "p2p_outliers";
  d.causes[0].estimate = d.causes[0].sigma = Eigen::Vector2d::Zero();
  EXPECT_THAT(VerdictSentence(d), Not(HasSubstr("0 +- 0")));
}

std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

TEST(GapSummary, FitsOnAScreen) {
  const std::string text = GapSummary(LeverArmDiagnosis());
  SCOPED_TRACE(text);
  const std::vector<std::string> lines = Lines(text);
  EXPECT_LT(lines.size(), 40u);
  EXPECT_EQ(lines[0], "flight somewhere: identified");
  EXPECT_THAT(lines[1], HasSubstr("the model lacks gnss_lever_arm"));
  EXPECT_THAT(text, HasSubstr("beyond noise: pairs 12.0 mm"));
  EXPECT_THAT(text, HasSubstr("where     lidar p2p, strip pair 1-2, scan angle 20..30 deg: 8.5"));
  EXPECT_THAT(text, HasSubstr("* gnss_lever_arm"));
  EXPECT_THAT(text,
              HasSubstr("before     0.002       0.03       92.0          -  0.20000, 0.03000"));
  EXPECT_THAT(text, HasSubstr("after       0.41      0.001       41.0"));
  EXPECT_THAT(text, HasSubstr("500 linear replicates"));
}

TEST(GapSummary, TellsOfWhatHasNoNameWhereItMayBeThere) {
  const std::string text = GapSummary(LeverArmDiagnosis());
  EXPECT_THAT(text, HasSubstr("laser vectors by strip        0.25      3.5  unmodelled"));
  EXPECT_THAT(text, Not(HasSubstr("boresight by time")));
}

TEST(GapSummary, TellsTheMostHarmfulOfWhatCouldHideFirst) {
  const std::string text = GapSummary(LeverArmDiagnosis());
  const std::size_t hidden = text.find("undetectable effects");
  ASSERT_NE(hidden, std::string::npos);
  EXPECT_LT(text.find("lidar_scan_cone", hidden), text.find("gnss_time_offset", hidden));
  EXPECT_LT(text.find("gnss_time_offset", hidden), text.find("lidar_range_scale", hidden));
}

TEST(GapSummary, OfAFlightThatCannotCarryItSaysOnlyWhy) {
  GapDiagnosis d = LeverArmDiagnosis();
  d.verdict.kind = GapVerdictKind::kUnavailable;
  d.p_value = std::nan("");
  d.could_still_hide.resize(1);
  d.verdict.text = VerdictSentence(d);
  EXPECT_EQ(GapSummary(d),
            "flight somewhere: unavailable\n"
            "  the flight cannot be diagnosed: one note\n"
            "undetectable effects\n"
            "          lidar_range_scale           below 40 ppm, not identifiable below 60, "
            "boresight shift up to 0.1, 0, 0 mdeg\n");
}

TEST(GapSummary, TellsOfAnySizeInOneLine) {
  GapDiagnosis d = LeverArmDiagnosis();
  d.could_still_hide.push_back(d.could_still_hide.back());
  d.could_still_hide.back().effect = "gravity_tilt";
  EXPECT_THAT(GapSummary(d), HasSubstr("at any size: lidar_scan_cone, gravity_tilt\n"));
  d.verdict.kind = GapVerdictKind::kNoGap;
  EXPECT_THAT(VerdictSentence(d), HasSubstr("at any size: lidar_scan_cone and one other"));
}

TEST(GapSummary, OfAFlightWithoutPairsMovesNoBoresight) {
  GapDiagnosis d = LeverArmDiagnosis();
  for (GapCause& cause : d.causes) cause.boresight_rad.setZero();
  for (DetectionLimit& effect : d.could_still_hide) effect.boresight_rad.setZero();
  const std::string text = GapSummary(d);
  EXPECT_THAT(text, AllOf(HasSubstr("gnss_time_offset            below 0.0012 s\n"),
                          Not(HasSubstr("mdeg]")), Not(HasSubstr("boresight shift"))));
  d.causes[0].sigma[0] = std::nan("");
  EXPECT_THAT(VerdictSentence(d), HasSubstr("gnss_lever_arm of 0.1, 0 +- 0.004"));
}

TEST(GapSummary, OfAnEmptyDiagnosisSaysNoMoreThanItKnows) {
  GapDiagnosis d;
  d.flight = "none";
  d.verdict.text = "nothing";
  const std::string text = GapSummary(d);
  EXPECT_THAT(text, HasSubstr("flight none: no_gap\n  nothing\n"));
  for (const char* part : {"where", "causes", "closed", "undetectable"}) {
    EXPECT_THAT(text, Not(HasSubstr(part)));
  }
}

TEST(GapPlots, DrawWhatTheDiagnosisHas) {
  const std::vector<GapPlot> plots = GapPlots(LeverArmDiagnosis());
  ASSERT_EQ(plots.size(), 3u);
  EXPECT_EQ(plots[0].file, "causes.svg");
  EXPECT_EQ(plots[0].panels[0].rows[0], "gnss_lever_arm (0.97)");
  EXPECT_EQ(plots[0].panels[0].series[0].points[0].first, 45.25);
  EXPECT_EQ(plots[1].file, "fingerprint.svg");
  ASSERT_EQ(plots[1].panels[0].rows.size(), 2u);
  EXPECT_EQ(plots[1].panels[0].series[0].points[0].first, 8.0);
  EXPECT_EQ(plots[1].panels[0].series[2].points.size(), 2u);
  EXPECT_EQ(plots[2].file, "before_after.svg");
  EXPECT_EQ(plots[2].panels[0].rows[1], "pairs [mm]: 92, then 41");
  EXPECT_NEAR(plots[2].panels[0].series[1].points[1].first, 41.0 / 92.0, kRoundings);
  EXPECT_TRUE(GapPlots({}).empty());
}

}  // namespace dn::diagnosis_test
