#include <dn/blind_check/blind_score.h>
#include <dn/error.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace dn::blind_check_test {

using ::testing::HasSubstr;

struct Said {
  std::string verdict;
  std::vector<std::string> effects;
  std::vector<std::string> credible_set = {};
};

BlindRecord Record(int number, const std::vector<std::string>& truth, const Said& said) {
  BlindRecord record;
  record.number = number;
  record.content = truth.empty()       ? BlindContent::kNothing
                   : truth.size() == 1 ? BlindContent::kOneEffect
                                       : BlindContent::kTwoEffects;
  for (const std::string& name : truth) {
    Effect effect;
    effect.name = name;
    effect.value = {0.03};
    record.effects.push_back(effect);
  }
  BlindDiagnosis diagnosis;
  diagnosis.verdict = said.verdict;
  diagnosis.detected = said.verdict != "no_gap";
  diagnosis.effects = said.effects;
  diagnosis.credible_set = said.credible_set;
  record.diagnosis.result = diagnosis;
  return record;
}

BlindRecord Outside(int number, const Said& said, bool unknown = false) {
  BlindRecord record = Record(number, {}, said);
  record.content = BlindContent::kUnlistedEffect;
  record.outsider = {"scan_torsion", {}};
  record.diagnosis.result->unknown = unknown;
  return record;
}

TEST(BlindScore, AnEffectLeftOutIsToBeRejected) {
  const auto left_out = [](int number, const Said& said) {
    BlindRecord record = Record(number, {"lidar_range_offset"}, said);
    record.content = BlindContent::kLeftOut;
    return record;
  };
  const BlindScore score = ScoreBlindFlights(
      {left_out(1, {"unknown", {}}), left_out(2, {"partial", {"lidar_range_scale"}}),
       left_out(3, {"identified", {"lidar_range_scale"}}), left_out(4, {"no_gap", {}})});
  EXPECT_EQ(score.outsider_detected.hits, 3);
  EXPECT_EQ(score.outsider_detected.of, 4);
  EXPECT_EQ(score.outsider_rejected.hits, 2);
  EXPECT_EQ(score.outsider_misnamed.hits, 1);
  ASSERT_EQ(score.outsiders.size(), 1u);
  EXPECT_EQ(score.outsiders[0].outsider, "lidar_range_offset");
  EXPECT_EQ(score.one_detected.of, 0);
}

TEST(Share, WilsonsIntervalOfKnownCases) {
  const Share one{1, 10};  // Newcombe 1998 gives 0.0179 .. 0.4042
  EXPECT_NEAR(one.interval_95().low, 0.0179, 5e-4);
  EXPECT_NEAR(one.interval_95().high, 0.4042, 5e-4);
  EXPECT_EQ((Share{0, 20}).interval_95().low, 0.0);
  EXPECT_NEAR((Share{0, 20}).interval_95().high, 0.1611, 5e-4);
  EXPECT_EQ((Share{20, 20}).interval_95().high, 1.0);
  EXPECT_TRUE(std::isnan(Share{}.value()));
}

TEST(BlindScore, AveragedBoresightsAreCountedByVerdict) {
  BlindRecord near = Record(1, {}, {"no_gap", {}}), far = Record(2, {}, {"unknown", {}});
  near.diagnosis.result->averaged = BlindAverage{{1.0, -1.9, 0.0}, 4.6};
  far.diagnosis.result->averaged = BlindAverage{{1.0, 2.1, 0.0}, 7.9};
  const BlindScore score = ScoreBlindFlights({near, far, Record(3, {}, {"no_gap", {}})});
  ASSERT_EQ(score.averaged.size(), 3u);
  EXPECT_EQ(score.averaged[0].verdict, "no_gap");
  EXPECT_EQ(score.averaged[0].in_region_95.hits, 1);
  EXPECT_EQ(score.averaged[1].in_region_95.hits, 0);
  EXPECT_EQ(score.averaged[2].verdict, "all");
  EXPECT_EQ(score.averaged[2].in_region_95.of, 2);
  EXPECT_EQ(score.averaged[2].angles_95.hits, 5);
  EXPECT_THAT(FormatTable(score), HasSubstr("all, within the 95 % region"));
}

TEST(BlindScore, NamesAreRightStrictlyOrByTheGroup) {
  const BlindRecord right =
      Record(1, {"gnss_lever_arm"}, {"identified", {"gnss_lever_arm"}, {"gnss_lever_arm"}});
  EXPECT_TRUE(NamedStrictly(right));
  EXPECT_TRUE(NamedWithGroup(right));
  const Said group{"group", {"lidar_lever_arm"}, {"lidar_lever_arm", "gnss_lever_arm"}};
  EXPECT_FALSE(NamedStrictly(Record(1, {"gnss_lever_arm"}, group)));
  EXPECT_TRUE(NamedWithGroup(Record(1, {"gnss_lever_arm"}, group)));
  EXPECT_FALSE(NamedWithGroup(Record(1, {"gravity_tilt"}, group)));
  Said alone = group;
  alone.verdict = "identified";
  EXPECT_FALSE(NamedWithGroup(Record(1, {"gnss_lever_arm"}, alone)))
      << "the credible set counts only for a group";
  const BlindRecord more = Record(1, {"gnss_lever_arm"}, {"identified", {"gnss_lever_arm", "x"}});
  EXPECT_FALSE(NamedStrictly(more)) << "one name too many";
  EXPECT_FALSE(NamedStrictly(Record(1, {}, {"no_gap", {}})));
}

TEST(BlindScore, CountsByContent) {
  std::vector<BlindRecord> records;
  for (int k = 0; k < 18; ++k) records.push_back(Record(k, {}, {"no_gap", {}}));
  records.push_back(Record(18, {}, {"unknown", {}}));
  records.push_back(Record(19, {}, {"identified", {"gravity_tilt"}}));
  records.push_back(Record(20, {"gravity_tilt"}, {"identified", {"gravity_tilt"}}));
  records.push_back(Record(21, {"gravity_tilt"}, {"no_gap", {}}));
  records.push_back(Record(22, {"gnss_lever_arm"}, {"group", {"x"}, {"x", "gnss_lever_arm"}}));
  records.push_back(Record(23, {"gnss_lever_arm", "gravity_tilt"}, {"partial", {"gravity_tilt"}}));
  records.push_back(Outside(24, {"unknown", {}}, true));
  records.push_back(Outside(25, {"identified", {"lidar_scan_cone"}}));
  records.push_back(Outside(26, {"no_gap", {}}));
  const BlindScore score = ScoreBlindFlights(records);
  EXPECT_EQ(score.flights, 27);
  EXPECT_EQ(score.false_alarms.hits, 2);
  EXPECT_EQ(score.false_alarms.of, 20);
  EXPECT_TRUE(score.alarms_allowed.Contains(score.false_alarms.value()));
  EXPECT_EQ(score.false_names.hits, 1);
  EXPECT_EQ(score.one_detected.hits, 2);
  EXPECT_EQ(score.one_named.hits, 1);
  EXPECT_EQ(score.one_named_with_group.hits, 2);
  EXPECT_EQ(score.one_named.of, 3);
  EXPECT_EQ(score.two.named.hits, 0);
  EXPECT_EQ(score.two.members.hits, 1);
  EXPECT_EQ(score.two.members.of, 2);
  EXPECT_EQ(score.spurious, 1) << "x, in flight 22";
  EXPECT_EQ(score.outsider_detected.hits, 2);
  EXPECT_EQ(score.outsider_rejected.hits, 1);
  EXPECT_EQ(score.outsider_rejected.of, 2);
  EXPECT_EQ(score.outsider_misnamed.hits, 1);
  ASSERT_EQ(score.effects.size(), 2U);
  EXPECT_EQ(score.effects[1].effect, "gravity_tilt");
  EXPECT_EQ(score.effects[1].detected.hits, 1);
  EXPECT_EQ(score.effects[1].detected.of, 2);
  long by_size = 0;
  for (const SizeScore& size : score.sizes) by_size += size.detected.of;
  EXPECT_EQ(by_size, 3);
  long verdicts = 0;
  for (const VerdictCount& count : score.verdicts) verdicts += count.flights;
  EXPECT_EQ(verdicts, 27);
}

TEST(BlindScore, ThePosteriorIsComparedWithWhatIsThere) {
  std::vector<BlindRecord> records;
  for (int k = 0; k < 10; ++k) {
    records.push_back(Record(k, {k < 8 ? "gravity_tilt" : "gnss_lever_arm"}, {"identified", {}}));
    records.back().diagnosis.result->causes = {{"gravity_tilt", 0.81, {}, {}},
                                               {"gnss_lever_arm", std::nan(""), {}, {}},
                                               {"lidar_scan_cone", 1.0, {}, {}}};
  }
  const BlindScore score = ScoreBlindFlights(records);
  EXPECT_EQ(score.reliability[8].true_causes.hits, 8);
  EXPECT_EQ(score.reliability[8].true_causes.of, 10);
  EXPECT_NEAR(score.reliability[8].stated, 0.81, 1e-12);
  EXPECT_EQ(score.reliability[9].true_causes.of, 10) << "1 belongs to the last bin";
  EXPECT_EQ(score.reliability[9].true_causes.hits, 0);
  EXPECT_EQ(score.reliability[0].true_causes.of, 0);
  EXPECT_NEAR(score.truth_posterior.median, 0.81, 1e-12);
}

TEST(BlindScore, CoverageIsOfRightlyNamedEffects) {
  BlindRecord fixed = Record(1, {"gnss_lever_arm"}, {"identified", {"gnss_lever_arm"}});
  fixed.effects[0].value = {0.1, 0.0, 0.0};
  fixed.diagnosis.result->causes = {
      {"gnss_lever_arm", 1.0, {0.119, 0.021, 0.0}, {0.01, 0.01, 0.0}}};
  BlindRecord wrong = fixed;
  wrong.diagnosis.result->effects = {"gravity_tilt"};
  BlindRecord ratio = Record(2, {"gnss_noise_scale"}, {"identified", {"gnss_noise_scale"}});
  ratio.effects[0].value = {2.0};
  ratio.diagnosis.result->causes = {{"gnss_noise_scale", 1.0, {2.1}, {0.2}}};
  const BlindScore score = ScoreBlindFlights({fixed, wrong, ratio});
  EXPECT_EQ(score.fixed_coverage.hits, 1);
  EXPECT_EQ(score.fixed_coverage.of, 2) << "the third component has no sigma";
  EXPECT_EQ(score.stochastic_coverage.hits, 1);
  EXPECT_EQ(score.stochastic_coverage.of, 1);
}

TEST(BlindScore, BoresightsAreJudgedByVerdict) {
  std::vector<BlindRecord> records(4, Record(1, {}, {"no_gap", {}}));
  const auto say = [](const char* verdict, double error) {
    BlindCalibration calibration;
    calibration.verdict = verdict;
    calibration.error_sigmas = {error, 0.0, 0.0};
    return calibration;
  };
  records[0].calibrated.result = say("calibrated", 1.0);
  records[1].calibrated.result = say("calibrated", -7.0);
  records[2].calibrated.result = say("contradicted", 30.0);
  records[2].adapted.result = say("calibrated", 0.5);
  records[3].calibrated.failure = "exit code 1: no attitude";
  const BlindScore score = ScoreBlindFlights(records);
  ASSERT_EQ(score.calibrated.size(), 2U);
  EXPECT_EQ(score.calibrated[0].verdict, "calibrated");
  EXPECT_EQ(score.calibrated[0].flights, 2);
  EXPECT_EQ(score.calibrated[0].beyond_5_sigma, 1);
  EXPECT_NEAR(score.calibrated[0].rms_sigmas, std::sqrt(50.0 / 6.0), 1e-12);
  ASSERT_EQ(score.adapted.size(), 1U);
  EXPECT_EQ(score.adapted[0].beyond_5_sigma, 0);
  ASSERT_EQ(score.failures.size(), 1U);
  EXPECT_EQ(score.failures[0], "flight 1: dn calibrate: exit code 1: no attitude");
}

TEST(BlindScore, GradesOneEffectByHowStronglyItShows) {
  const auto shows = [](double sigmas, int number, const Said& said, double error_sigmas) {
    BlindRecord record = Record(number, {"lidar_range_offset"}, said);
    record.signature = {sigmas * sigmas, 0.0, "lidar_range_offset"};
    BlindCalibration calibration;
    calibration.verdict = said.verdict == "no_gap" ? "calibrated" : "contradicted";
    calibration.error_sigmas = {0.0, error_sigmas, 0.0};
    record.calibrated.result = calibration;
    return record;
  };
  const Said right{"identified", {"lidar_range_offset"}}, none{"no_gap", {}};
  const Said group{"group", {"lidar_range_scale"}, {"lidar_range_scale", "lidar_range_offset"}};
  const BlindScore score = ScoreBlindFlights(
      {shows(4.4, 1, none, 9.0), shows(4.6, 2, right, 9.0), shows(5.9, 3, none, 1.0),
       shows(6.1, 4, group, 9.0), shows(80.0, 5, right, 30.0), Record(6, {"gnss_outliers"}, none)});
  const auto is = [](const Share& share, long hits, long of) {
    EXPECT_EQ(share.hits, hits);
    EXPECT_EQ(share.of, of);
  };
  is(score.strengths[0].detected, 0, 1);
  is(score.strengths[0].calibrated_beyond_5_sigma, 1, 1);
  is(score.strengths[1].detected, 1, 2);
  is(score.strengths[1].calibrated_beyond_5_sigma, 0, 2);
  is(score.strengths[2].named, 0, 1);
  is(score.strengths[2].named_with_group, 1, 1);
  is(score.strengths[3].named, 1, 1);
  EXPECT_THAT(FormatTable(score), HasSubstr("4.5 to 6"));
  EXPECT_EQ(ToJson(score).at("by_strength").at(2).at("from_sigmas"), 6.0);
}

TEST(BlindScore, GradesWhatIsOutsideByWhatNoEffectCanMimic) {
  const auto with_left = [](double sigmas, BlindRecord record) {
    record.signature = {10.0 * sigmas * sigmas, sigmas * sigmas, "lidar_scan_cone"};
    return record;
  };
  const Said named{"identified", {"lidar_scan_cone"}}, unknown{"unknown", {}};
  const std::vector<BlindRecord> records{with_left(1.0, Outside(1, named)),
                                         with_left(4.9, Outside(2, {"no_gap", {}})),
                                         with_left(5.1, Outside(3, unknown)),
                                         with_left(7.9, Outside(4, named)),
                                         with_left(8.1, Outside(5, unknown)),
                                         with_left(90.0, Outside(6, unknown)),
                                         with_left(9.0, Outside(7, {"group", {"lidar_scan_cone"}})),
                                         Outside(8, unknown)};
  const BlindScore score = ScoreBlindFlights(records);
  const auto is = [](const Share& share, long hits, long of) {
    EXPECT_EQ(share.hits, hits);
    EXPECT_EQ(share.of, of);
  };
  is(score.signatures[0].detected, 1, 2);
  is(score.signatures[0].misnamed, 1, 1);
  is(score.signatures[1].rejected, 1, 2);
  is(score.signatures[1].misnamed, 1, 2);
  is(score.signatures[2].rejected, 2, 3);
  is(score.signatures[2].misnamed, 0, 3);
  is(score.outsider_detected, 7, 8);
  EXPECT_THAT(FormatTable(score), HasSubstr("above 8"));
  EXPECT_EQ(ToJson(score).at("by_signature").at(1).at("from_sigmas"), 5.0);
  EXPECT_THAT(FormatCsv(records), HasSubstr(",10,1,lidar_scan_cone,"));
}

TEST(BlindScore, WritesATableAJsonAndRows) {
  std::vector<BlindRecord> records{
      Record(1, {"gravity_tilt"}, {"identified", {"gravity_tilt"}, {"gravity_tilt"}}),
      Record(2, {}, {"no_gap", {}})};
  records[0].base = "lar2_rest";
  records[0].effects[0].value = {6.0, -3.0};
  records[0].diagnosis.result->shrinkage = 0.9;
  records[1].diagnosis.result.reset();
  records[1].diagnosis.failure = "exit code 1: \"no\" attitude";
  const BlindScore score = ScoreBlindFlights(records);
  EXPECT_THAT(FormatTable(score), HasSubstr("named alone"));
  const Json json = ToJson(score);
  EXPECT_EQ(json.at("schema"), "dn.blind_check/1");
  EXPECT_EQ(json.at("one_effect").at("named").at("hits"), 1);
  const std::string csv = FormatCsv(records);
  EXPECT_THAT(csv, HasSubstr("gravity_tilt,6 -3,1,1,"));
  EXPECT_THAT(csv, HasSubstr("\"exit code 1: \"\"no\"\" attitude\""));
  std::size_t columns = 0;
  for (std::size_t begin = 0; begin < csv.size();) {
    const std::size_t end = csv.find('\n', begin);
    const std::string row = csv.substr(begin, end - begin);
    const auto commas = static_cast<std::size_t>(std::count(row.begin(), row.end(), ','));
    if (columns == 0) columns = commas;
    EXPECT_EQ(commas, columns) << row;
    begin = end + 1;
  }
}

TEST(BlindScore, OfNothingIsRefused) { EXPECT_THROW(ScoreBlindFlights({}), InvalidInput); }

}  // namespace dn::blind_check_test
