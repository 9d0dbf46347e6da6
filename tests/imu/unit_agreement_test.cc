#include <dn/imu/unit_agreement.h>
#include <dn/rotation.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace dn::imu_test {

constexpr double kSigmas = 4.0;
constexpr double kNoise_radps = 2e-3;

/// Returns the rates of a body that turns about all axes, aperiodically.
Eigen::Vector3d Rates(double t_s) {
  return {0.3 * std::sin(0.9 * t_s + 0.002 * t_s * t_s),
          0.2 * std::sin(1.7 * t_s) * std::cos(0.11 * t_s),
          0.4 * std::sin(0.23 * t_s + 0.003 * t_s * t_s)};
}

/// A unit on the body: clock, axes and noise.
struct Unit {
  double offset_s = 0.0, drift = 0.0;
  Eigen::Quaterniond q_unit_body = Eigen::Quaterniond::Identity();
  double rate_hz = 100.0;
  unsigned seed = 1;
  double bending_radps = 0.0;         // rate at which the axes turn about x
  double noise_radps = kNoise_radps;  // of means over a tenth of a second

  ImuData Record(double length_s) const {
    ImuData imu;
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0.0, noise_radps * std::sqrt(0.1 * rate_hz));
    const double dt_s = 1.0 / rate_hz;
    for (double t_s = dt_s; t_s < length_s; t_s += dt_s) {
      const Eigen::Quaterniond bend = Exp(Eigen::Vector3d(bending_radps * t_s, 0.0, 0.0));
      ImuSample sample{t_s + offset_s + drift * t_s, dt_s};
      sample.w_ib_b_radps = bend * (q_unit_body * Rates(t_s - 0.5 * dt_s));
      for (double& w : sample.w_ib_b_radps) w += noise(random);
      imu.samples.push_back(sample);
    }
    imu.nominal_dt_s = dt_s;
    return imu;
  }
};

Unit OtherUnit() {
  const Eigen::Quaterniond q = Exp(Eigen::Vector3d(3.0, 0.1, -0.2));
  return {.offset_s = 187.3, .drift = 2e-4, .q_unit_body = q, .rate_hz = 120.0, .seed = 2};
}

TEST(UnitAgreement, FindsClockAndAxesWithinTheirSigmas) {
  const Unit other = OtherUnit();
  const auto found = CompareUnits(Unit{}.Record(200.0), other.Record(200.0));
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->offset_s, other.offset_s + other.drift * found->first_s,
              kSigmas * found->sigma_offset_s);
  EXPECT_LT(found->sigma_offset_s, 1e-3);
  EXPECT_NEAR(found->drift, other.drift, kSigmas * found->sigma_drift);
  const Eigen::Vector3d turn = Log(Eigen::Quaterniond(found->q_ba * other.q_unit_body.conjugate()));
  EXPECT_LT(turn.cwiseQuotient(found->sigma_rotation_rad).cwiseAbs().maxCoeff(), kSigmas);
  EXPECT_GT(found->p_value, 1e-3);
  EXPECT_NEAR(found->noise_radps, std::sqrt(2.0) * kNoise_radps, 0.2 * kNoise_radps);
}

// A record with few rows per second, such as the attitudes in the log of a flight controller.
TEST(UnitAgreement, RowsMayBeRare) {
  for (const double rate_hz : {10.0, 5.0, 2.0}) {
    SCOPED_TRACE(rate_hz);
    Unit other = OtherUnit();
    other.rate_hz = rate_hz;
    other.offset_s = -497.13;
    const auto found = CompareUnits(Unit{}.Record(400.0), other.Record(400.0));
    ASSERT_TRUE(found);
    const double true_s = other.offset_s + other.drift * found->first_s;
    EXPECT_NEAR(found->offset_s, true_s, kSigmas * found->sigma_offset_s);
    EXPECT_LT(found->noise_radps, 0.1 * found->motion_radps);
  }
  Unit rare = OtherUnit();
  rare.rate_hz = 2.0;
  EXPECT_FALSE(CompareUnits(Unit{}.Record(90.0), rare.Record(90.0)));
}

// The offset must not depend on where the rows of a noisy log lie between the bins.
TEST(UnitAgreement, NoiseOfRareRowsDoesNotMoveTheOffset) {
  double sum = 0.0, square = 0.0;
  constexpr int kLogs = 24;
  for (int k = 0; k < kLogs; ++k) {
    SCOPED_TRACE(k);
    Unit log = OtherUnit();
    log.rate_hz = 10.0;
    log.noise_radps = 0.03;
    log.drift = 0.0;
    log.offset_s = -497.0 + 0.1 * k / kLogs;
    log.seed = 100 + k;
    const auto found = CompareUnits(Unit{}.Record(400.0), log.Record(400.0));
    ASSERT_TRUE(found);
    const double middle_s = 0.5 * (found->last_s - found->first_s);
    const double error_s = found->offset_s + found->drift * middle_s - log.offset_s;
    EXPECT_LT(std::abs(error_s), kSigmas * found->sigma_offset_s);
    sum += error_s / found->sigma_offset_s;
    square += std::pow(error_s / found->sigma_offset_s, 2);
  }
  // The offset in the middle of the record has half the sigma of that at its begin.
  EXPECT_LT(std::abs(sum / kLogs), kSigmas / std::sqrt(kLogs));
  EXPECT_LT(square / kLogs, 1.0);
}

TEST(UnitAgreement, UnitsThatTurnAgainstEachOtherDisagree) {
  Unit other = OtherUnit();
  other.bending_radps = 2e-4;
  const auto found = CompareUnits(Unit{}.Record(200.0), other.Record(200.0));
  ASSERT_TRUE(found);
  EXPECT_LT(found->p_value, 1e-6);
}

TEST(UnitAgreement, OtherMotionsAndTurnsAboutOneAxisAreNotCompared) {
  const ImuData a = Unit{}.Record(100.0);
  ImuData other = a, about_x = a;
  for (ImuSample& sample : other.samples) sample.w_ib_b_radps = Rates(1.37 * sample.t_s + 1000.0);
  EXPECT_FALSE(CompareUnits(a, other));
  for (ImuSample& sample : about_x.samples) sample.w_ib_b_radps.tail<2>().setZero();
  EXPECT_FALSE(CompareUnits(about_x, about_x));
  EXPECT_FALSE(CompareUnits(Unit{}.Record(15.0), Unit{}.Record(15.0)));
}

}  // namespace dn::imu_test
