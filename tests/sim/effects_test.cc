#include <dn/error.h>
#include <dn/rotation.h>
#include <dn/sim/simulate.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "sim/small_scenario.h"

namespace dn::sim_test {

using Eigen::Vector3d;
using ::testing::HasSubstr;

constexpr double kRounding = 1e-11;
// Error of the conversion to geodetic coordinates and back.
constexpr double kPositionRounding_m = 1e-7;

/// Provides one flight without effects for all tests, and flights with the same seed and effects.
class Effects : public ::testing::Test {
 protected:
  static const SimulatedFlight& Clean() {
    static const SimulatedFlight clean = Simulate(testing::SmallScenario(), {});
    return clean;
  }

  static SimulatedFlight With(const std::string& effects, bool noise = true) {
    SimulateOptions options;
    options.noise = noise;
    return Simulate(testing::SmallScenario("effects: [" + effects + "]\n"), options);
  }

  static std::vector<Vector3d> AntennaShift(const SimulatedFlight& a, const SimulatedFlight& b) {
    std::vector<Vector3d> shift;
    for (std::size_t k = 0; k < a.flight.gnss->epochs.size(); ++k) {
      const Vector3d pa = a.flight.gnss->epochs[k].p_m;
      const Vector3d pb = b.flight.gnss->epochs[k].p_m;
      shift.emplace_back(b.frame.R_m_enu(pb).transpose() * (pa - pb));
    }
    return shift;
  }

  using Each = std::function<void(const ImuSample& with, const ImuSample& clean, std::size_t k)>;
  static void EachSample(const SimulatedFlight& with, const Each& use) {
    const auto& samples = with.flight.imu->samples;
    ASSERT_EQ(samples.size(), Clean().flight.imu->samples.size());
    for (std::size_t k = 0; k < samples.size(); ++k) {
      use(samples[k], Clean().flight.imu->samples[k], k);
    }
  }

  // Subtracts bias and noise, which are the same in both flights.
  static Vector3d TrueRate(const ImuSample& measured, const ImuSample& clean,
                           const ImuSample& exact) {
    return measured.w_ib_b_radps - (clean.w_ib_b_radps - exact.w_ib_b_radps);
  }

  static const SimulatedFlight& Exact() {
    static const SimulatedFlight exact = With("", false);
    return exact;
  }
};

TEST_F(Effects, ZeroSizeChangesNothing) {
  const SimulatedFlight zero = With(
      "{effect: gnss_time_offset, value: 0}, {effect: gnss_correlated_noise, value: [0, 0, 0, 9]},"
      "{effect: gnss_multipath, value: [0, 0, 0, 9]},"
      "{effect: gnss_noise_scale, value: 1}, {effect: accel_scale_factor, value: [0, 0, 0]},"
      "{effect: gyro_misalignment, value: [0, 0, 0]}, {effect: gyro_bias_process, value: [0, 9]},"
      "{effect: gravity_tilt, value: [0, 0]}, {effect: p2p_outliers, value: [0, 5]},"
      "{effect: p2p_range_noise, value: 0}, {effect: lidar_time_drift, value: 0}");
  EachSample(zero, [](const ImuSample& with, const ImuSample& clean, std::size_t) {
    ASSERT_EQ(with.w_ib_b_radps, clean.w_ib_b_radps);
    ASSERT_EQ(with.f_b_mps2, clean.f_b_mps2);
    ASSERT_EQ(with.t_s, clean.t_s);
  });
  for (const Vector3d& shift : AntennaShift(zero, Clean())) {
    ASSERT_LT(shift.norm(), kPositionRounding_m);
  }
  for (std::size_t k = 0; k < Clean().flight.pairs->pairs.size(); ++k) {
    ASSERT_EQ(zero.flight.pairs->pairs[k].u_j_s, Clean().flight.pairs->pairs[k].u_j_s);
    ASSERT_EQ(zero.flight.pairs->pairs[k].t_i_s, Clean().flight.pairs->pairs[k].t_i_s);
  }
}

TEST_F(Effects, GnssPositionStepLastsForItsWindow) {
  const SimulatedFlight with =
      With("{effect: gnss_position_step, value: [1, -2, 3], window_s: [381100, 381120]}");
  const std::vector<Vector3d> shift = AntennaShift(with, Clean());
  for (std::size_t k = 0; k < shift.size(); ++k) {
    const double t_s = with.flight.gnss->epochs[k].t_s;
    const bool inside = t_s >= 381100.0 && t_s <= 381120.0;
    const Vector3d expected = inside ? Vector3d(1.0, -2.0, 3.0) : Vector3d::Zero().eval();
    ASSERT_LT((shift[k] - expected).norm(), kPositionRounding_m) << t_s;
  }
}

// The sample standard deviation of a process scatters by about sqrt(1/n) if the record lasts n tau.
TEST_F(Effects, GnssCorrelatedNoiseIsGaussMarkov) {
  constexpr double kTau_s = 4.0;
  const SimulatedFlight with = With("{effect: gnss_correlated_noise, value: [0.1, 0.2, 0.4, 4]}");
  const std::vector<Vector3d> x = AntennaShift(with, Clean());
  const auto n = static_cast<double>(x.size());
  Vector3d variance = Vector3d::Zero(), lagged = Vector3d::Zero();
  for (std::size_t k = 1; k < x.size(); ++k) {
    variance += x[k].cwiseAbs2() / n;
    lagged += x[k].cwiseProduct(x[k - 1]) / n;
  }
  const double step_s = Clean().flight.gnss->epochs[1].t_s - Clean().flight.gnss->epochs[0].t_s;
  const double independent = n * step_s / (2.0 * kTau_s);
  const Vector3d sigma(0.1, 0.2, 0.4);
  for (int i = 0; i < 3; ++i) {
    const double ratio = variance[i] / (sigma[i] * sigma[i]);
    EXPECT_NEAR(ratio, 1.0, 4.0 * std::sqrt(2.0 / independent));
    EXPECT_NEAR(lagged[i] / variance[i], std::exp(-step_s / kTau_s), 0.1);
  }
}

/// Returns |roll| / 30 deg of the true attitude at each GNSS epoch of the clean flight.
std::vector<double> BankRatios(const SimulatedFlight& clean) {
  constexpr double k30Deg = std::numbers::pi / 6.0;
  std::vector<double> ratios;
  for (const MapGnssEpoch& epoch : clean.flight.gnss->epochs) {
    const double roll_rad = RollPitchHeading(clean.truth->Nav(epoch.t_s).q_nb).x();
    ratios.push_back(std::abs(roll_rad) / k30Deg);
  }
  return ratios;
}

// The error divided by the bank is a Gauss-Markov process, and so independent of the bank.
TEST_F(Effects, GnssMultipathIsGaussMarkovTimesTheBank) {
  constexpr double kTau_s = 4.0;
  const SimulatedFlight with = With("{effect: gnss_multipath, value: [0.1, 0.2, 0.4, 4]}");
  const std::vector<Vector3d> shift = AntennaShift(with, Clean());
  const std::vector<double> bank = BankRatios(Clean());
  const auto n = static_cast<double>(shift.size());
  Vector3d variance = Vector3d::Zero(), lagged = variance, before = variance;
  for (std::size_t k = 0; k < shift.size(); ++k) {
    const Vector3d x = shift[k] / bank[k];
    variance += x.cwiseAbs2() / n;
    lagged += x.cwiseProduct(before) / n;
    before = x;
  }
  const double step_s = Clean().flight.gnss->epochs[1].t_s - Clean().flight.gnss->epochs[0].t_s;
  const double independent = n * step_s / (2.0 * kTau_s);
  const Vector3d sigma(0.1, 0.2, 0.4);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(variance[i] / (sigma[i] * sigma[i]), 1.0, 4.0 * std::sqrt(2.0 / independent));
    EXPECT_NEAR(lagged[i] / variance[i], std::exp(-step_s / kTau_s), 0.1);
  }
}

TEST_F(Effects, GnssMultipathIsLargeInTurnsOnly) {
  const SimulatedFlight with = With("{effect: gnss_multipath, value: [0.3, 0.3, 0.3, 0.5]}");
  const std::vector<Vector3d> shift = AntennaShift(with, Clean());
  const std::vector<double> bank = BankRatios(Clean());
  double turns_m2 = 0.0, level_m2 = 0.0, num_turns = 0.0, num_level = 0.0;
  for (std::size_t k = 0; k < shift.size(); ++k) {
    const bool turning = bank[k] > 0.7, level = bank[k] < 0.1;  // 21 deg and 3 deg
    turns_m2 += turning ? shift[k].squaredNorm() / 3.0 : 0.0;
    level_m2 += level ? shift[k].squaredNorm() / 3.0 : 0.0;
    num_turns += turning ? 1.0 : 0.0;
    num_level += level ? 1.0 : 0.0;
  }
  ASSERT_GT(num_turns, 80.0);
  ASSERT_GT(num_level, 80.0);
  const double at_25_deg_m = 0.3 * 25.0 / 30.0;
  EXPECT_NEAR(std::sqrt(turns_m2 / num_turns) / at_25_deg_m, 1.0, 0.25);
  EXPECT_LT(std::sqrt(level_m2 / num_level), 0.1 * 0.3);
}

TEST_F(Effects, GnssNoiseScaleMultipliesTheErrors) {
  const SimulatedFlight with = With("{effect: gnss_noise_scale, value: 3}");
  const std::vector<Vector3d> three = AntennaShift(with, Exact());
  const std::vector<Vector3d> one = AntennaShift(Clean(), Exact());
  for (std::size_t k = 0; k < one.size(); ++k) {
    ASSERT_LT((three[k] - 3.0 * one[k]).norm(), kPositionRounding_m);
  }
  EXPECT_EQ(*with.flight.gnss->epochs[0].covariance_enu_m2,
            *Clean().flight.gnss->epochs[0].covariance_enu_m2)
      << "the stated sigmas stay";
}

TEST_F(Effects, GnssOutliersHaveTheGivenShareAndSize) {
  constexpr double kShare = 0.1, kSize_m = 20.0;
  const SimulatedFlight with = With("{effect: gnss_outliers, value: [0.1, 20]}");
  double wrong = 0.0, sum_m = 0.0;
  const std::vector<Vector3d> shift = AntennaShift(with, Clean());
  for (const Vector3d& d : shift) {
    if (d.norm() < 1e-3) continue;
    ++wrong;
    sum_m += d.norm();
    EXPECT_LE(d.norm(), kSize_m + kPositionRounding_m);
  }
  const auto n = static_cast<double>(shift.size());
  EXPECT_NEAR(wrong / n, kShare, 4.0 * std::sqrt(kShare * (1.0 - kShare) / n));
  EXPECT_NEAR(sum_m / wrong, 0.5 * kSize_m, 4.0 * kSize_m / std::sqrt(12.0 * wrong));
}

TEST_F(Effects, GnssOutageLeavesOutEpochs) {
  const SimulatedFlight with = With("{effect: gnss_outage, window_s: [381100, 381130]}");
  const auto& epochs = with.flight.gnss->epochs;
  EXPECT_TRUE(std::none_of(epochs.begin(), epochs.end(), [](const MapGnssEpoch& e) {
    return e.t_s >= 381100.0 && e.t_s <= 381130.0;
  }));
  EXPECT_EQ(Clean().flight.gnss->epochs.size() - epochs.size(), 61U) << "2 Hz for 30 s, both ends";
  EXPECT_THROW(With("{effect: gnss_outage, window_s: [0, 600000]}"), InvalidConfig);
}

TEST_F(Effects, DriftGrowsFromTheFirstEpochAndAddsToOffset) {
  const SimulatedFlight with = With(
      "{effect: gnss_time_offset, value: 0.25}, {effect: gnss_time_drift, value: 200},"
      "{effect: gnss_outage, window_s: [381000, 381020]}");
  const auto& epochs = with.flight.gnss->epochs;
  const double first_s = epochs.front().t_s - 0.25;
  ASSERT_GT(first_s, 381020.0);
  for (std::size_t k = 0; k < epochs.size(); ++k) {
    const double since_s = std::round(2.0 * (epochs[k].t_s - epochs.front().t_s)) / 2.0;
    ASSERT_NEAR(epochs[k].t_s, first_s + 0.25 + since_s * (1.0 + 200e-6), 1e-9);
  }
}

TEST_F(Effects, ClocksShiftTheTagsAndNothingElse) {
  const SimulatedFlight with = With(
      "{effect: gnss_time_offset, value: 0.01}, {effect: gnss_clock_step, value: 0.1, t0_s: "
      "381100},"
      "{effect: imu_clock_step, value: 0.01, t0_s: 381150}");
  for (std::size_t k = 0; k < Clean().flight.gnss->epochs.size(); ++k) {
    const double t_s = Clean().flight.gnss->epochs[k].t_s;
    ASSERT_NEAR(with.flight.gnss->epochs[k].t_s - t_s, t_s >= 381100.0 ? 0.11 : 0.01, 1e-9);
    ASSERT_EQ(with.flight.gnss->epochs[k].p_m, Clean().flight.gnss->epochs[k].p_m);
  }
  EachSample(with, [](const ImuSample& late, const ImuSample& clean, std::size_t) {
    ASSERT_NEAR(late.t_s - clean.t_s, clean.t_s >= 381150.0 ? 0.01 : 0.0, 1e-9);
    ASSERT_EQ(late.w_ib_b_radps, clean.w_ib_b_radps);
  });
  EXPECT_THROW(With("{effect: gnss_clock_step, value: -2, t0_s: 381100}"), InvalidConfig);
  EXPECT_THROW(With("{effect: imu_clock_step, value: -2, t0_s: 381100}"), InvalidConfig);
}

TEST_F(Effects, ImuGapIsThatOfAReader) {
  const SimulatedFlight with = With("{effect: imu_gap, window_s: [381100, 381101]}");
  const ImuData& imu = *with.flight.imu;
  ASSERT_EQ(imu.gaps.size(), 1U);
  EXPECT_NEAR(imu.gaps[0].t_begin_s, 381100.0 - imu.nominal_dt_s, 1e-6);
  EXPECT_NEAR(imu.gaps[0].t_end_s, 381101.0, 1e-6);
  EXPECT_EQ(with.gyro_bias_radps.size(), imu.samples.size());
  EXPECT_LT(imu.max_jitter_s, 1e-6);
}

TEST_F(Effects, MisalignmentScaleAndSensitivityInTheirOrder) {
  const SimulatedFlight with = With(
      "{effect: gyro_misalignment, value: [1, -2, 3]}, {effect: gyro_scale_factor, value: [500, 0, "
      "-300]}, {effect: gyro_g_sensitivity, value: [1, 2, 3]}, {effect: accel_misalignment, value: "
      "[2, 0, -1]}, {effect: accel_scale_factor, value: [0, 200, 100]}");
  const Eigen::Matrix3d turn_w = Exp(Vector3d(-1e-3, 2e-3, -3e-3)).toRotationMatrix();
  const Eigen::Matrix3d turn_f = Exp(Vector3d(-2e-3, 0.0, 1e-3)).toRotationMatrix();
  const Vector3d scale_w(1.0005, 1.0, 0.9997), scale_f(1.0, 1.0002, 1.0001);
  const Vector3d sensitivity = Vector3d(1.0, 2.0, 3.0) * kRadPerDeg / 3600.0 / 9.80665;
  EachSample(with, [&](const ImuSample& sample, const ImuSample& clean, std::size_t k) {
    const ImuSample& exact = Exact().flight.imu->samples[k];
    const Vector3d w = scale_w.cwiseProduct(turn_w * exact.w_ib_b_radps) +
                       sensitivity.cwiseProduct(exact.f_b_mps2);
    const Vector3d f = scale_f.cwiseProduct(turn_f * exact.f_b_mps2);
    ASSERT_LT((TrueRate(sample, clean, exact) - w).norm(), kRounding);
    ASSERT_LT((sample.f_b_mps2 - (clean.f_b_mps2 - exact.f_b_mps2) - f).norm(), 1e-10);
  });
}

TEST_F(Effects, NoiseAndBiasAddToTheAssumedOnes) {
  const SimulatedFlight with = With(
      "{effect: gyro_noise_scale, value: 2}, {effect: accel_noise_scale, value: 3},"
      "{effect: gyro_bias_process, value: [50, 20]}, {effect: accel_bias_process, value: [5, 20]}");
  Vector3d gyro2 = Vector3d::Zero(), accel2 = gyro2;
  EachSample(with, [&](const ImuSample& sample, const ImuSample& clean, std::size_t k) {
    const ImuSample& exact = Exact().flight.imu->samples[k];
    const Vector3d white_w = clean.w_ib_b_radps - exact.w_ib_b_radps - Clean().gyro_bias_radps[k];
    const Vector3d white_f = clean.f_b_mps2 - exact.f_b_mps2 - Clean().accel_bias_mps2[k];
    ASSERT_LT(
        (sample.w_ib_b_radps - exact.w_ib_b_radps - with.gyro_bias_radps[k] - 2.0 * white_w).norm(),
        kRounding);
    ASSERT_LT((sample.f_b_mps2 - exact.f_b_mps2 - with.accel_bias_mps2[k] - 3.0 * white_f).norm(),
              1e-10);
    gyro2 += (with.gyro_bias_radps[k] - Clean().gyro_bias_radps[k]).cwiseAbs2();
    accel2 += (with.accel_bias_mps2[k] - Clean().accel_bias_mps2[k]).cwiseAbs2();
  });
  const auto n = static_cast<double>(with.gyro_bias_radps.size());
  // The flight has about ten independent values on each of three axes, so that the rms scatters by
  // a tenth.
  EXPECT_NEAR(std::sqrt(gyro2.sum() / 3.0 / n) / (50.0 * kRadPerDeg / 3600.0), 1.0, 0.4);
  EXPECT_NEAR(std::sqrt(accel2.sum() / 3.0 / n) / (5e-3 * 9.80665), 1.0, 0.4);
}

TEST_F(Effects, VibrationIsWhiteInItsWindow) {
  const SimulatedFlight with =
      With("{effect: imu_vibration, value: [0.1, 0.3], window_s: [381100, 381200]}");
  double n = 0.0;
  Vector3d w2 = Vector3d::Zero(), f2 = w2;
  EachSample(with, [&](const ImuSample& sample, const ImuSample& clean, std::size_t) {
    const Vector3d dw = sample.w_ib_b_radps - clean.w_ib_b_radps;
    const Vector3d df = sample.f_b_mps2 - clean.f_b_mps2;
    if (sample.t_s < 381100.0 || sample.t_s > 381200.0) {
      ASSERT_EQ(dw.norm() + df.norm(), 0.0);
      return;
    }
    w2 += dw.cwiseAbs2();
    f2 += df.cwiseAbs2();
    ++n;
  });
  const double bound = 4.0 / std::sqrt(2.0 * 3.0 * n);
  EXPECT_NEAR(std::sqrt(w2.sum() / 3.0 / n) / (0.1 * kRadPerDeg), 1.0, bound);
  EXPECT_NEAR(std::sqrt(f2.sum() / 3.0 / n) / 0.3, 1.0, bound);
}

// The plumb line is tilted to the north: gravity gains a northern component, and specific force
// loses it.
TEST_F(Effects, GravityTurnsAndGrows) {
  const SimulatedFlight tilted = With("{effect: gravity_tilt, value: [20, -10]}", false);
  const SimulatedFlight heavier = With("{effect: gravity_disturbance, value: 50}", false);
  const auto& frame = Clean().frame;
  constexpr double kRadPerArcsecond = kRadPerDeg / 3600.0;
  for (std::size_t k = 0; k < Exact().flight.imu->samples.size(); k += 50) {
    const ImuSample& exact = Exact().flight.imu->samples[k];
    const MapPose pose = Exact().truth->Pose(exact.t_s - 0.5 * exact.dt_s);
    const auto to_enu = [&](const Vector3d& f_b) {
      return Vector3d(frame.R_m_enu(pose.p_mb).transpose() * (pose.q_mb * f_b));
    };
    const double g = frame.Gravity(pose.p_mb).norm();
    const Vector3d d = to_enu(tilted.flight.imu->samples[k].f_b_mps2 - exact.f_b_mps2);
    const Vector3d expected(10.0 * kRadPerArcsecond * g, -20.0 * kRadPerArcsecond * g, 0.0);
    ASSERT_LT((d - expected).norm(), 1e-3 * expected.norm());
    const Vector3d up = to_enu(heavier.flight.imu->samples[k].f_b_mps2 - exact.f_b_mps2);
    ASSERT_LT((up - Vector3d(0.0, 0.0, 50e-5)).norm(), 1e-6);
  }
}

TEST_F(Effects, WrongPairs) {
  const SimulatedFlight with = With("{effect: p2p_outliers, value: [0.2, 5]}");
  double wrong = 0.0;
  const auto& pairs = with.flight.pairs->pairs;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const LidarPair& clean = Clean().flight.pairs->pairs[k];
    EXPECT_EQ(pairs[k].u_i_s, clean.u_i_s);
    const double d_m = (pairs[k].u_j_s - clean.u_j_s).norm();
    EXPECT_LE(d_m, 5.0);
    wrong += d_m > 0.0 ? 1.0 : 0.0;
  }
  const auto n = static_cast<double>(pairs.size());
  EXPECT_NEAR(wrong / n, 0.2, 4.0 * std::sqrt(0.2 * 0.8 / n));
}

TEST_F(Effects, NoiseOfThePairs) {
  const SimulatedFlight scaled = With("{effect: p2p_noise_scale, value: 2}");
  const SimulatedFlight far = With("{effect: p2p_range_noise, value: 0.3}");
  for (std::size_t k = 0; k < Exact().flight.pairs->pairs.size(); ++k) {
    const LidarPair& exact = Exact().flight.pairs->pairs[k];
    const Vector3d noise = Clean().flight.pairs->pairs[k].u_i_s - exact.u_i_s;
    ASSERT_LT((scaled.flight.pairs->pairs[k].u_i_s - exact.u_i_s - 2.0 * noise).norm(), 1e-9);
    const double range_km = 0.5e-3 * (exact.u_i_s.norm() + exact.u_j_s.norm());
    const double ratio = std::hypot(1.0, 0.3 * range_km / 0.05);
    ASSERT_LT((far.flight.pairs->pairs[k].u_i_s - exact.u_i_s - ratio * noise).norm(), 1e-9);
  }
}

TEST_F(Effects, RangeAngleAndClockOfTheScanner) {
  const SimulatedFlight range = With(
      "{effect: lidar_range_offset, value: 0.05}, {effect: lidar_range_scale, value: 100}", false);
  const SimulatedFlight angle = With("{effect: lidar_angle_scale, value: 1000}", false);
  const SimulatedFlight drift = With("{effect: lidar_time_drift, value: 10}", false);
  const LidarScenario& lidar = Exact().scenario.lidar;
  const auto scan_angle = [&](const Vector3d& u) {
    return std::atan2(u.dot(lidar.scan_axis_s.cross(lidar.nadir_axis_s)),
                      u.dot(lidar.nadir_axis_s));
  };
  double first_s = 1e300;
  for (const LidarPair& pair : Exact().flight.pairs->pairs) {
    first_s = std::min({first_s, pair.t_i_s, pair.t_j_s});
  }
  for (std::size_t k = 0; k < Exact().flight.pairs->pairs.size(); ++k) {
    const LidarPair& exact = Exact().flight.pairs->pairs[k];
    ASSERT_NEAR(range.flight.pairs->pairs[k].u_i_s.norm(), 1.0001 * exact.u_i_s.norm() + 0.05,
                1e-9);
    const Vector3d& turned = angle.flight.pairs->pairs[k].u_j_s;
    ASSERT_NEAR(scan_angle(turned), 1.001 * scan_angle(exact.u_j_s), 1e-12);
    ASSERT_NEAR(turned.norm(), exact.u_j_s.norm(), 1e-9);
    ASSERT_NEAR(drift.flight.pairs->pairs[k].t_j_s - exact.t_j_s, 1e-5 * (exact.t_j_s - first_s),
                1e-9);
  }
}

TEST_F(Effects, AttitudeOffsetTurnsTheGivenTrajectoryAlone) {
  const SimulatedFlight with =
      With("{effect: trajectory_attitude_offset, value: [0.05, 0.01, 0.2]}");
  EXPECT_FALSE(Clean().flight.trajectory);
  ASSERT_TRUE(with.flight.trajectory);
  const Eigen::Quaterniond offset = Exp(Vector3d(kRadPerDeg * Vector3d(0.05, 0.01, 0.2)));
  const auto& given = with.flight.trajectory->points();
  const auto& truth = with.flight.reference->points();
  ASSERT_EQ(given.size(), truth.size());
  for (std::size_t k = 0; k < given.size(); ++k) {
    EXPECT_LT(given[k].q_nb.angularDistance(truth[k].q_nb * offset), kRounding);
    EXPECT_EQ(given[k].position.h_m, truth[k].position.h_m);
  }
  EachSample(with, [](const ImuSample& sample, const ImuSample& clean, std::size_t) {
    ASSERT_EQ(sample.w_ib_b_radps, clean.w_ib_b_radps);
  });
}

}  // namespace dn::sim_test
