#include <dn/imu/imu_means.h>
#include <dn/imu/preintegration.h>
#include <gtest/gtest.h>

#include "testing/earth_motion.h"

namespace dn::imu_test {

using Eigen::Vector3d;

/// Returns samples of 4 ms whose rates and forces contain their index.
ImuData Numbered(int samples) {
  ImuData imu;
  for (int k = 0; k < samples; ++k) {
    imu.samples.push_back(
        {10.0 + 0.004 * (k + 1), 0.004, Vector3d::Constant(k), Vector3d::Constant(-2.0 * k)});
  }
  imu.nominal_dt_s = 0.004;
  return imu;
}

/// Effect that tilts the x axes of both triads towards y.
class LeaningAxis final : public ImuEffect {
 public:
  int components() const override { return 1; }
  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               ImuReading* reading) const override {
    reading->w_b.x() -= value[0] * reading->w_b.y();
    reading->f_b.x() -= value[0] * reading->f_b.y();
    reading->J_w(0, column) = -reading->w_b.y();
    reading->J_f(0, column) = -reading->f_b.y();
  }
};

TEST(AverageSamples, KeepsTheIntegralsAndTheSpan) {
  const ImuData means = AverageSamples(Numbered(12), 0.02);
  ASSERT_EQ(means.samples.size(), 3U);  // of five, five and two samples
  EXPECT_NEAR(means.samples[0].dt_s, 0.02, 1e-12);
  EXPECT_NEAR(means.samples[0].w_ib_b_radps.x(), 2.0, 1e-9);
  EXPECT_NEAR(means.samples[1].f_b_mps2.z(), -14.0, 1e-9);
  EXPECT_NEAR(means.samples[2].w_ib_b_radps.y(), 10.5, 1e-9);
  EXPECT_DOUBLE_EQ(means.t_begin_s(), Numbered(12).t_begin_s());
  EXPECT_DOUBLE_EQ(means.t_end_s(), Numbered(12).t_end_s());
  EXPECT_DOUBLE_EQ(means.nominal_dt_s, 0.02);
}

TEST(AverageSamples, WeighsByTheLengthOfTheSamples) {
  ImuData imu;
  imu.samples = {{0.001, 0.001, Vector3d::Constant(4.0), Vector3d::Zero()},
                 {0.004, 0.003, Vector3d::Constant(8.0), Vector3d::Zero()}};
  const ImuData means = AverageSamples(imu, 0.01);
  ASSERT_EQ(means.samples.size(), 1U);
  EXPECT_NEAR(means.samples[0].w_ib_b_radps.x(), 7.0, 1e-12);
}

TEST(AverageSamples, LeavesLongerSamplesAsTheyAre) {
  const ImuData means = AverageSamples(Numbered(4), 0.001);
  ASSERT_EQ(means.samples.size(), 4U);
  EXPECT_EQ(means.samples[2].w_ib_b_radps, Vector3d::Constant(2.0));
  EXPECT_DOUBLE_EQ(means.nominal_dt_s, 0.004);
}

TEST(AverageSamples, JoinsNothingOverAGap) {
  ImuData imu = Numbered(6);
  for (std::size_t k = 3; k < 6; ++k) imu.samples[k].t_s += 1.0;
  imu.gaps = {{imu.samples[2].t_s, imu.samples[3].t_s - 0.004}};
  const ImuData means = AverageSamples(imu, 0.02);
  ASSERT_EQ(means.samples.size(), 2U);
  EXPECT_NEAR(means.samples[0].w_ib_b_radps.x(), 1.0, 1e-12);
  EXPECT_NEAR(means.samples[1].w_ib_b_radps.x(), 4.0, 1e-12);
  EXPECT_NEAR(means.samples[1].dt_s, 0.012, 1e-12);
  EXPECT_TRUE(HasGap(means, 10.0, 11.0));
}

TEST(AverageSamples, LeavesASampleThatBridgesAHoleByItself) {
  ImuData imu = Numbered(5);
  imu.bridges = {{.t_begin_s = 10.008, .row = imu.samples[2], .gyro_sigma_rad = 1e-3}};
  const ImuData means = AverageSamples(imu, 0.02);
  ASSERT_EQ(means.samples.size(), 3U);
  EXPECT_EQ(means.samples[1].t_s, imu.samples[2].t_s);
  ASSERT_EQ(means.bridges.size(), 1U);
}

// The motion of the vehicle within 20 ms hardly changes the derivatives of increments with respect
// to an effect.
TEST(AverageSamples, SufficeForDerivativesByEffects) {
  const ImuData imu = testing::PlaneMotion().Measure(0.0, 2.0, 500.0);
  const ImuCorrection at{.effects = {{std::make_shared<LeaningAxis>(), Eigen::VectorXd::Zero(1)}}};
  const Preintegrated whole = Preintegrate(imu, 0.303, 1.307, at, {});
  const Preintegrated by_means = Preintegrate(AverageSamples(imu, 0.02), 0.303, 1.307, at, {});
  const auto difference = (by_means.J_effects - whole.J_effects).eval();
  for (int part = 0; part < 3; ++part) {
    EXPECT_LT(difference.middleRows(3 * part, 3).norm(),
              1e-4 * whole.J_effects.middleRows(3 * part, 3).norm());
  }
}

}  // namespace dn::imu_test
