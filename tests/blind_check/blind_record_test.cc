#include <dn/blind_check/blind_record.h>
#include <dn/error.h>
#include <gtest/gtest.h>

#include <cmath>

namespace dn::blind_check_test {

const Eigen::Vector3d kTrue_deg(0.1, -0.3, 0.54);

Json GapJson() {
  return Json::parse(R"({
    "schema": "dn.gap/1", "flight": "x",
    "gap": {"detected": true, "p_value": 0.002,
            "size_nats_per_obs": {"value": 0.03, "null_interval_95": [-0.01, 0.01],
                                  "upper_limit_95": 0.05},
            "user_units": {"p2p_excess_mm": 3.0}},
    "where": [],
    "causes": [{"effect": "gnss_lever_arm", "log_evidence": 12.0, "posterior": 0.9,
                "p_value": 1e-5, "estimate": [0.1, null, 0.0], "sigma": [0.01, 0.02, 0.03],
                "unit": "m"},
               {"effect": "lidar_lever_arm", "posterior": 0.05, "estimate": null, "sigma": null}],
    "verdict": {"kind": "group", "effects": ["gnss_lever_arm"],
                "credible_set": ["gnss_lever_arm", "lidar_lever_arm"], "unknown": false,
                "tie_breaker": "", "text": ""},
    "shrinkage": {"fraction": 0.8, "interval_95": [0.7, 0.9]},
    "boresight_averaged": {"angles_deg": [0.12, -0.3, 0.5], "sigma_deg": [0.01, 0.02, 0.04],
                           "covariance_deg2": [[1e-4, 0, 0], [0, 4e-4, 0], [0, 0, 16e-4]]},
    "could_still_hide": []})");
}

TEST(BlindRecord, ReadsADiagnosis) {
  const BlindDiagnosis diagnosis = DiagnosisFromGapJson(GapJson(), kTrue_deg);
  EXPECT_TRUE(diagnosis.detected);
  EXPECT_EQ(diagnosis.p_value, 0.002);
  EXPECT_EQ(diagnosis.verdict, "group");
  EXPECT_EQ(diagnosis.effects, std::vector<std::string>{"gnss_lever_arm"});
  EXPECT_EQ(diagnosis.credible_set.size(), 2U);
  EXPECT_EQ(diagnosis.shrinkage, 0.8);
  EXPECT_EQ(diagnosis.size_nats_per_obs, 0.03);
  ASSERT_TRUE(diagnosis.averaged.has_value());
  EXPECT_NEAR(diagnosis.averaged->error_sigmas[0], 2.0, 0.02);
  EXPECT_NEAR(diagnosis.averaged->error_sigmas[2], -1.0, 0.02);
  EXPECT_NEAR(diagnosis.averaged->nees, 5.0, 0.1);
  ASSERT_EQ(diagnosis.causes.size(), 2U);
  EXPECT_EQ(diagnosis.causes[0].sigma[2], 0.03);
  EXPECT_TRUE(std::isnan(diagnosis.causes[0].estimate[1]));
  EXPECT_TRUE(diagnosis.causes[1].estimate.empty());
}

TEST(BlindRecord, ADiagnosisWithoutAGapHasNoShrinkage) {
  Json gap = GapJson();
  gap["shrinkage"] = nullptr;
  gap["boresight_averaged"] = nullptr;
  gap["gap"]["size_nats_per_obs"] = nullptr;
  const BlindDiagnosis diagnosis = DiagnosisFromGapJson(gap, kTrue_deg);
  EXPECT_EQ(diagnosis.shrinkage, std::nullopt);
  EXPECT_FALSE(diagnosis.averaged.has_value());
  EXPECT_EQ(diagnosis.size_nats_per_obs, std::nullopt);
}

TEST(BlindRecord, RefusesWhatIsNoDiagnosis) {
  for (const char* section : {"gap", "causes", "verdict", "shrinkage"}) {
    Json gap = GapJson();
    gap.erase(section);
    EXPECT_THROW(DiagnosisFromGapJson(gap, kTrue_deg), InvalidInput) << section;
  }
}

TEST(BlindRecord, ComparesABoresightWithTheTrueOne) {
  const Json result = Json::parse(R"({"assessment": {"verdict": "calibrated"},
    "boresight": {"angles_deg": [0.12, -0.3, 0.5], "sigma_deg": [0.01, 0.02, 0.04]}})");
  const BlindCalibration calibration = CalibrationFromResultJson(result, {0.1, -0.3, 0.54});
  EXPECT_EQ(calibration.verdict, "calibrated");
  EXPECT_NEAR(calibration.error_sigmas[0], 2.0, 0.02);
  EXPECT_NEAR(calibration.error_sigmas[1], 0.0, 0.02);
  EXPECT_NEAR(calibration.error_sigmas[2], -1.0, 0.02);
  EXPECT_NEAR(calibration.worst(), 2.0, 0.02);
  Json broken = result;
  broken.erase("boresight");
  EXPECT_THROW(CalibrationFromResultJson(broken, {}), InvalidInput);
}

TEST(BlindRecord, SurvivesItsFile) {
  BlindRecord record;
  record.number = 7;
  record.seed = 18446744073709551557U;
  record.base = "lar2_rest";
  record.content = BlindContent::kTwoEffects;
  Effect step, window;
  step.name = "boresight_step";
  step.value = {0.1, -1.0 / 3.0, 0.0};
  step.times.t0_s = 381200.5;
  window.name = "imu_vibration";
  window.value = {0.1, 0.3};
  window.times.window_s = {381000.25, 381010.0};
  record.effects = {step, window};
  record.boresight_deg = {0.1, 0.2, 1.0 / 7.0};
  record.strips = 3;
  record.diagnosis.result = DiagnosisFromGapJson(GapJson(), kTrue_deg);
  record.diagnosis.time_s = 12.5;
  record.calibrated.failure = "exit code 1: no attitude";
  const std::string text = ToJson(record).dump();
  const BlindRecord back = BlindRecordFromJson(Json::parse(text));
  EXPECT_EQ(ToJson(back).dump(), text);
  EXPECT_EQ(back.seed, record.seed);
  EXPECT_EQ(back.content, BlindContent::kTwoEffects);
  EXPECT_EQ(back.effects[0].times.t0_s, step.times.t0_s);
  EXPECT_EQ(back.effects[1].times.window_s, window.times.window_s);
  EXPECT_FALSE(back.calibrated.result);

  EXPECT_FALSE(back.signature);

  record.outsider = {"scan_torsion", {{"amplitude_deg", 0.02}, {"harmonic", 4}}};
  record.signature = {400.0, 1.0 / 3.0, "lidar_scan_cone"};
  const BlindRecord outside = BlindRecordFromJson(ToJson(record));
  ASSERT_TRUE(outside.outsider);
  EXPECT_EQ(outside.outsider->parameters.at("harmonic"), 4);
  ASSERT_TRUE(outside.signature);
  EXPECT_EQ(outside.signature->lambda_left, 1.0 / 3.0);
  EXPECT_EQ(outside.signature->nearest, "lidar_scan_cone");
}

}  // namespace dn::blind_check_test
