#include <dn/adjustment/words.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace dn::adjustment_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kDeg = kRadPerDeg;

EffectCheck LateTags() {
  EffectCheck effect;
  effect.name = "lidar_time_offset";
  effect.unit = "ms";
  effect.remedy = "estimate it";
  effect.p_value = 1e-20;
  effect.estimate = Eigen::VectorXd::Constant(1, 20.0);
  effect.sigma = Eigen::VectorXd::Constant(1, 0.5);
  effect.boresight_rad = Eigen::Vector3d(0.1, -0.02, 0.003) * kDeg;
  effect.max_shift_sigmas = 12.0;
  return effect;
}

TEST(Words, VerdictsAreThoseOfTheResultFile) {
  EXPECT_STREQ(Word(Verdict::kCalibrated), "calibrated");
  EXPECT_STREQ(Word(Verdict::kAbsorbed), "absorbed");
  EXPECT_STREQ(Word(Verdict::kNotObservable), "not_observable");
  EXPECT_STREQ(Word(Verdict::kContradicted), "contradicted");
}

TEST(Words, AnEffectIsReportedWithItsShift) {
  facts::EffectPresent fact{LateTags(), true};
  EXPECT_EQ(Words(Finding{fact}),
            "the data indicate lidar_time_offset = 20 +- 0.5 ms (p < 1e-12), which moves the "
            "boresight by 100, -20, 3 mdeg (12.0 sigma): estimate it");
  fact.moves_boresight = false;
  fact.effect.inseparable_from = {"a", "b"};
  EXPECT_EQ(Words(Finding{fact}),
            "the data indicate lidar_time_offset = 20 +- 0.5 ms (p < 1e-12), which moves the "
            "trajectory (12.0 sigma); a or b would explain the data nearly as well: estimate it");
}

TEST(Words, ADiscrepancyIsReportedWithItsShift) {
  DiscrepancyCheck check;
  check.name = "laser vectors by scan angle";
  check.p_value = 2e-5;
  check.max_shift_sigmas = 5.36;
  EXPECT_THAT(
      Words(Finding{facts::UnmodelledDiscrepancy{check}, true}),
      HasSubstr("laser vectors by scan angle show a discrepancy that no known effect explains "
                "(p = 2e-05); it may move the boresight by 5.4 sigma"));
}

TEST(Words, ACompetingEffectIsReportedWithItsShift) {
  CompetingEffectCheck check{"gyro_misalignment", "accel_misalignment", -0.5, {}, 33.3};
  check.boresight_rad = Eigen::Vector3d(28.7, -23.5, 19.9) * 1e-3 * kRadPerDeg;
  EXPECT_THAT(Words(Finding{facts::UnknownAmbiguous{check, true}}),
              HasSubstr("accel_misalignment instead of gyro_misalignment explains the data equally "
                        "well, and moves the boresight by 28.7, -23.5, 19.9 mdeg (33.3 sigma)"));
  EXPECT_THAT(Words(Finding{facts::UnknownAmbiguous{check, false}}),
              HasSubstr("moves the trajectory"));
}

TEST(Words, AnglesHaveTheirNames) {
  EXPECT_THAT(Words(Finding{facts::SigmaTooLarge{2}}), HasSubstr("of yaw exceeds 0.5 deg"));
  EXPECT_THAT(Words(Finding{facts::SigmaAbovePairs{0}}), HasSubstr("of roll exceeds ten times"));
  EXPECT_THAT(Words(Finding{facts::AnglesInseparable{0, 1}}),
              HasSubstr("roll and pitch cannot be separated"));
}

TEST(Words, BothSidesOfATestHaveTheirWords) {
  EXPECT_THAT(Words(Finding{facts::InnovationSize{"GNSS velocities", 1.756}}),
              HasSubstr("of the GNSS velocities are 1.76 times as large as the model expects: the "
                        "stated sigmas or the inertial noise are too small"));
  EXPECT_THAT(Words(Finding{facts::InnovationSize{"GNSS positions", 0.5}}),
              HasSubstr("the stated sigmas are too large"));
  EXPECT_THAT(Words(Finding{facts::NetworkDiffers{Eigen::Vector3d::Zero(), 1e-4, true}}),
              HasSubstr("more than their covariances explain"));
  EXPECT_THAT(Words(Finding{facts::NetworkDiffers{Eigen::Vector3d::Zero(), 0.4, false}}),
              HasSubstr("within what their covariances explain"));
}

TEST(Words, TheFileOverridesTheCorrelationTimeOfThePairs) {
  facts::SigmasWidened fact;
  fact.ratio = {2.0, 3.0, 4.0};
  fact.scaled_rad = fact.constant_rad = Eigen::Vector3d::Constant(0.001 * kDeg);
  fact.correlated_rad = Eigen::Vector3d::Constant(0.002 * kDeg);
  fact.source = "a.txt";
  fact.tau_s = 41.0;
  EXPECT_THAT(Words(Finding{fact}), HasSubstr("as stated by a.txt, is absorbed without showing"));
  EXPECT_THAT(Words(Finding{fact}), Not(HasSubstr("41 s")));
  fact.tau_shown = true;
  EXPECT_THAT(Words(Finding{fact}), HasSubstr("a correlation time of about 41 s, which contribute "
                                              "0.00200, 0.00200, 0.00200 deg to the sigmas"));
  fact.tau_stated = true;
  EXPECT_THAT(Words(Finding{fact}),
              HasSubstr("according to a.txt they are time-correlated, and contribute"));
  EXPECT_THAT(Words(Finding{fact}), Not(HasSubstr("41 s")));
}

}  // namespace dn::adjustment_test
