#include <dn/error.h>
#include <dn/geo/text_table.h>
#include <dn/imu/imu_data.h>
#include <dn/imu/preintegration.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>

#include "testing/expect_invalid.h"
#include "testing/temp_file.h"

namespace dn::imu_test {

using Eigen::Vector3d;
using testing::ExpectInvalid;
using testing::TempFile;

constexpr char kFour[] =
    "100.00, 0.1, 0.2, 0.3, 1, 2, -9.0\n"
    "100.01, 0.3, 0.4, 0.5, 3, 4, -9.2  # comment\n"
    "100.02, 0.5, 0.6, 0.7, 5, 6, -9.4\n"
    "100.03, 0.7, 0.8, 0.9, 1, 2, -9.6\n";

ImuData Read(const std::string& text, const ImuReadOptions& options = {}) {
  const TempFile file("IMU.txt", text);
  return ReadImu(file.path(), options);
}

TEST(ReadImu, MeansOverTheIntervalThatEndsAtTheTag) {
  const ImuData imu = Read(kFour);
  ASSERT_EQ(imu.samples.size(), 4u);
  EXPECT_NEAR(imu.nominal_dt_s, 0.01, 1e-12);
  EXPECT_NEAR(imu.t_begin_s(), 99.99, 1e-12);  // the first interval is as long as the others
  EXPECT_EQ(imu.t_end_s(), 100.03);
  EXPECT_EQ(imu.samples[1].w_ib_b_radps, Vector3d(0.3, 0.4, 0.5));
  EXPECT_EQ(imu.samples[1].f_b_mps2, Vector3d(3, 4, -9.2));
  EXPECT_TRUE(imu.gaps.empty());
  EXPECT_LE(imu.max_jitter_s, 1e-12);
}

TEST(ReadImu, PointSamplesBecomeMeansOfTheirEnds) {
  const ImuData imu = Read(kFour, {.sampling = ImuSampling::kInstantaneous});
  ASSERT_EQ(imu.samples.size(), 3u);
  EXPECT_NEAR(imu.t_begin_s(), 100.00, 1e-12);
  EXPECT_LE((imu.samples[0].w_ib_b_radps - Vector3d(0.2, 0.3, 0.4)).norm(), 1e-15);
  EXPECT_LE((imu.samples[0].f_b_mps2 - Vector3d(2, 3, -9.1)).norm(), 1e-15);
}

TEST(ReadImu, FluBecomesFrd) {
  const ImuData imu = Read(kFour, {.R_imu_to_body = Vector3d(1, -1, -1).asDiagonal()});
  EXPECT_EQ(imu.samples[0].w_ib_b_radps, Vector3d(0.1, -0.2, -0.3));
  EXPECT_EQ(imu.samples[0].f_b_mps2, Vector3d(1, -2, 9.0));
}

// The file has other units, axes and clock than the program.
TEST(ReadImu, UnitsAxesAndClockOfTheFile) {
  Eigen::Matrix3d R_frd_from_rfu;
  R_frd_from_rfu << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  const ImuData imu = Read(
      "1419000000.00, 18, 9, 0, 0.5, 2, 1\n1419000000.01, 18, 9, 0, 0.5, 2, 1\n"
      "1419000000.02, 18, 9, 0, 0.5, 2, 1\n",
      {.rate_unit_radps = 3.14159265358979 / 180.0,
       .force_unit_mps2 = 2.0,
       .R_imu_to_body = R_frd_from_rfu,
       .time_offset_s = 1419000000.0});
  EXPECT_EQ(imu.t_end_s(), 1419000000.02 - 1419000000.0);
  EXPECT_LT((imu.samples[0].w_ib_b_radps - Vector3d(0.05, 0.1, 0) * 3.14159265358979).norm(),
            1e-12);
  EXPECT_EQ(imu.samples[0].f_b_mps2, Vector3d(4, 1, -2));
}

TEST(ReadImu, RowsThatRepeatTheValuesBeforeAreCounted) {
  const ImuData imu = Read(
      "0.00,0.1,0,0,0,0,-9.8\n0.01,0.1,0,0,0,0,-9.8\n0.02,0.2,0,0,0,0,-9.8\n"
      "0.03,0.2,0,0,0,0,-9.8\n0.04,0.1,0,0,0,0,-9.8\n");
  EXPECT_EQ(imu.repeated_values, 2);
  EXPECT_EQ(imu.samples.size(), 5u);
}

// Rates are increments divided by the interval of each row; an odometer column is ignored.
TEST(ReadImu, Increments) {
  const ImuData imu = Read(
      "0.00 1e-3 0 0 0 0 -0.098 7\n0.01 2e-3 0 0 0 0 -0.098 7\n"
      "0.022 3e-3 0 0 0 0 -0.12 7\n0.03 1e-3 0 0 0 0 -0.08 7\n",
      {.format = ImuFormat::kIncrements});
  ASSERT_EQ(imu.samples.size(), 4u);
  EXPECT_NEAR(imu.samples[1].w_ib_b_radps.x(), 0.2, 1e-12);
  EXPECT_NEAR(imu.samples[2].w_ib_b_radps.x(), 0.25, 1e-12);
  EXPECT_NEAR(imu.samples[2].f_b_mps2.z(), -10.0, 1e-12);
  EXPECT_NEAR(imu.max_jitter_s, 0.002, 1e-12);
}

TEST(ReadImu, SpanIsCutAndCounted) {
  const ImuData imu = Read(kFour, {.t_begin_s = 100.005, .t_end_s = 100.025});
  ASSERT_EQ(imu.samples.size(), 2u);
  EXPECT_EQ(imu.rows_outside_span, 2);
  EXPECT_NEAR(imu.t_begin_s(), 100.00, 1e-12);  // begin of the sample that ends at 100.01
}

TEST(ReadImu, GapStaysVisible) {
  const std::string text = std::string(kFour) + "100.10, 0, 0, 0, 0, 0, -9.8\n";
  for (const ImuSampling sampling : {ImuSampling::kMean, ImuSampling::kInstantaneous}) {
    const ImuData imu = Read(text, {.sampling = sampling});
    ASSERT_EQ(imu.gaps.size(), 1u);
    EXPECT_TRUE(imu.bridges.empty());
    EXPECT_NEAR(imu.gaps[0].t_begin_s, 100.03, 1e-12);
    EXPECT_NEAR(imu.gaps[0].t_end_s, 100.09, 1e-12);
    EXPECT_NEAR(imu.samples.back().dt_s, 0.01, 1e-12);
    EXPECT_EQ(imu.samples.back().f_b_mps2, Vector3d(0, 0, -9.8));  // not bridged
    EXPECT_LE(imu.max_jitter_s, 1e-12);
  }
}

/// Returns 100 Hz rows of rates that are linear in time, sampled according to `sampling`, without
/// rows [first, last).
std::string RampWithout(int first, int last, ImuSampling sampling) {
  std::string text;
  for (int i = 0; i < 60; ++i) {
    if (i >= first && i < last) continue;
    const double seen_s = 0.01 * i - (sampling == ImuSampling::kMean ? 0.005 : 0.0);
    text += FormatDouble(100.0 + 0.01 * i) + ", " + FormatDouble(2.0 * seen_s) + ", 0, 0, 0, " +
            FormatDouble(seen_s) + ", -9.8\n";
  }
  return text;
}

TEST(ReadImu, AHoleOfUpToFourRowsIsBridged) {
  for (const ImuSampling sampling : {ImuSampling::kMean, ImuSampling::kInstantaneous}) {
    const ImuData whole = Read(RampWithout(0, 0, sampling), {.sampling = sampling});
    for (const int lost : {1, 4}) {
      SCOPED_TRACE(lost);
      const ImuData imu = Read(RampWithout(20, 20 + lost, sampling), {.sampling = sampling});
      EXPECT_TRUE(imu.gaps.empty());
      EXPECT_FALSE(HasGap(imu, imu.t_begin_s(), imu.t_end_s()));
      ASSERT_EQ(imu.bridges.size(), 1u);
      EXPECT_NEAR(imu.bridges[0].t_begin_s, 100.19, 1e-12);
      EXPECT_NEAR(imu.bridges[0].row.t_s, 100.20 + 0.01 * lost, 1e-12);
      EXPECT_NEAR(imu.bridges[0].row.dt_s, 0.01, 1e-12);
      EXPECT_LE(imu.max_jitter_s, 1e-12);
      // Rates that the interpolation reproduces lose nothing.
      const PreintegrationNoise noise{1e-4, 1e-3, 0.0};
      const auto increment = [&](const ImuData& x) {
        return Preintegrate(x, 100.1, 100.4, {}, noise);
      };
      EXPECT_LT(increment(imu).delta_q.angularDistance(increment(whole).delta_q), 1e-7);
      // The slope within a sample assumes that its neighbours are equally long.
      EXPECT_LT((increment(imu).delta_v - increment(whole).delta_v).norm(), 5e-6);
      EXPECT_LT((increment(imu).covariance - increment(whole).covariance).norm(), 1e-10);
    }
    EXPECT_EQ(Read(RampWithout(20, 25, sampling), {.sampling = sampling}).gaps.size(), 1u);
  }
}

TEST(ReadImu, TheLongestBridgeIsConfigured) {
  const std::string text = RampWithout(20, 30, ImuSampling::kMean);
  EXPECT_EQ(Read(text).gaps.size(), 1u);
  EXPECT_TRUE(Read(text, {.max_gap_s = 0.2}).gaps.empty());
  EXPECT_EQ(Read(RampWithout(20, 21, ImuSampling::kMean), {.max_gap_s = 0.011}).gaps.size(), 1u);
  EXPECT_THROW(Read(text, {.max_gap_s = 0.005}), InvalidConfig);
}

// The rates jump at every row: the error of a bridge is that of the same interpolation elsewhere.
TEST(ReadImu, ABridgeHasTheErrorOfInterpolation) {
  std::string text;
  for (int i = 0; i < 80; ++i) {
    if (i == 41) continue;
    text += FormatDouble(100.0 + 0.01 * i) + (i % 2 == 0 ? ", 0.2, 0, 0" : ", 0, 0, 0") +
            (i % 2 == 0 ? ", 0, 0, -9\n" : ", 0, 0, -10\n");
  }
  const ImuData imu = Read(text);
  ASSERT_EQ(imu.bridges.size(), 1u);
  EXPECT_NEAR(imu.bridges[0].gyro_sigma_rad, 0.2 * 0.01, 1e-12);
  EXPECT_NEAR(imu.bridges[0].accel_sigma_mps, 1.0 * 0.01, 1e-12);
  const PreintegrationNoise noise{1e-5, 1e-4, 0.0};
  const auto variance = [&](double t0_s, double t1_s) {
    return Preintegrate(imu, t0_s, t1_s, {}, noise).covariance(0, 0);
  };
  EXPECT_NEAR(variance(100.3, 100.5) - variance(100.1, 100.3), std::pow(0.2 * 0.01, 2), 1e-14);
  EXPECT_NEAR(variance(100.41, 100.5), variance(100.21, 100.3) + 0.5 * std::pow(0.2 * 0.01, 2),
              1e-14);
}

TEST(ReadImu, HolesNextToEachOtherAreBridgedOneByOne) {
  std::string text;
  for (int i = 0; i < 40; ++i) {
    if (i == 20 || i == 22) continue;
    text += FormatDouble(100.0 + 0.01 * i) + ", " + FormatDouble(0.01 * i) + ", 0, 0, 0, 0, -9.8\n";
  }
  const ImuData imu = Read(text);
  ASSERT_EQ(imu.bridges.size(), 2u);
  EXPECT_NEAR(imu.samples[20].w_ib_b_radps.x(), 0.205, 1e-12);
  EXPECT_NEAR(imu.samples[20].dt_s, 0.02, 1e-12);
  EXPECT_NEAR(imu.samples[21].dt_s, 0.02, 1e-12);
  EXPECT_NEAR(imu.samples[21].w_ib_b_radps.x(), 0.225, 1e-12);
}

// The tags come from a coarse clock: the median interval, 0.006 s, differs from the mean.
TEST(ReadImu, JitterIsNotAGap) {
  const ImuData imu = Read(
      "408640.961,0,0,0,0,0,-9.8\n408640.967,0,0,0,0,0,-9.8\n408640.973,0,0,0,0,0,-9.8\n"
      "408640.9823,0,0,0,0,0,-9.8\n408640.9883,0,0,0,0,0,-9.8\n");
  EXPECT_TRUE(imu.gaps.empty());
  EXPECT_NEAR(imu.nominal_dt_s, 0.0273 / 4.0, 1e-9);
  EXPECT_NEAR(imu.samples[3].dt_s, 0.0093, 1e-9);
  EXPECT_NEAR(imu.max_jitter_s, 0.0093 - 0.0273 / 4.0, 1e-9);
}

/// Returns 1000 Hz rows of a constant turn about z. Every fifth step is `long_s` instead of a
/// millisecond.
std::string Bursts(double long_s) {
  std::string text;
  double t_s = 0.0;
  for (int i = 0; i < 200; ++i) {
    t_s += i % 5 == 0 ? long_s : 0.001;
    text += FormatDouble(t_s) + ", 0, 0, 0.5, 0, 0, -9.8\n";
  }
  return text;
}

// A logger that writes in bursts: the long steps are as valid as the others.
TEST(ReadImu, UnevenStepsAreData) {
  std::string text;
  double t_s = 0.0;
  for (int i = 0; i < 200; ++i) {
    t_s += 0.002 + 0.007 * (i % 3);
    text += FormatDouble(t_s) + ", 0, 0, 0.5, 0, 0, -9.8\n";
  }
  for (const ImuSampling sampling : {ImuSampling::kMean, ImuSampling::kInstantaneous}) {
    const ImuData imu = Read(text, {.sampling = sampling});
    EXPECT_TRUE(imu.uneven);
    EXPECT_TRUE(imu.gaps.empty());
    EXPECT_TRUE(imu.bridges.empty());
    EXPECT_NEAR(imu.nominal_dt_s, 0.009, 2e-4);
    EXPECT_NEAR(imu.max_jitter_s, 0.007, 2e-4);
    const ImuSample& sample = imu.samples[100];
    EXPECT_NEAR(sample.dt_s, sample.t_s - imu.samples[99].t_s, 1e-12);
  }
}

TEST(ReadImu, StepsOfMillisecondsAreNoGapsAtAnyRate) {
  const ImuData imu = Read(Bursts(0.04));
  EXPECT_FALSE(imu.uneven);
  EXPECT_TRUE(imu.gaps.empty());
  EXPECT_EQ(imu.bridges.size(), 39u);
  EXPECT_EQ(Read(Bursts(0.06)).gaps.size(), 39u);
}

TEST(ReadImu, RolloverIsContinuedAndRepeatedRowsAreDropped) {
  const ImuData imu = Read(
      "604799.98,0,0,0,0,0,-9.8\n604799.99,0,0,0,0,0,-9.8\n604799.99,0,0,0,0,0,-9.8\n"
      "0.00,0,0,0,0,0,-9.8\n0.01,0,0,0,0,0,-9.8\n");
  ASSERT_EQ(imu.samples.size(), 4u);
  EXPECT_EQ(imu.repeated_rows_dropped, 1);
  EXPECT_NEAR(imu.t_end_s(), 604800.01, 1e-9);
  EXPECT_TRUE(imu.gaps.empty());
}

TEST(ReadImu, RejectsBadRowsByLine) {
  ExpectInvalid([] { Read("0,0,0,0,0,0,-9.8\n0.01,0,0,0,0,-9.8\n"); }, "column", 2);
  ExpectInvalid([] { Read("0,0,0,0,0,0,-9.8\n0.01,0,0,x,0,0,-9.8\n"); }, "x", 2);
  ExpectInvalid([] { Read("0,0,0,0,0,0,-9.8\n0.01,0,0,nan,0,0,-9.8\n"); }, "", 2);
  ExpectInvalid([] { Read("0,0,0,0,0,0,-9.8\n\n0.01,0,0,0,0,0,-9.8\n0.01,0,0,0,0,0,-9.7\n"); }, "",
                4);
  ExpectInvalid([] { Read("0.02,0,0,0,0,0,-9.8\n0.01,0,0,0,0,0,-9.8\n"); }, "", 2);
  ExpectInvalid([] { Read("0,0,0,0,0,0,-9.8\n"); }, "at least 2", 1);
  EXPECT_THROW(Read(""), InvalidInput);
  EXPECT_THROW(ReadImu("/nowhere/IMU.txt", {}), InvalidInput);
  EXPECT_THROW(Read("0 0 0 0 0 0 -9.8 1\n0.01 0 0 0 0 0 -9.8 1\n"),
               InvalidInput);  // format odyn has 7 columns
  ExpectInvalid([] { Read(kFour, {.t_begin_s = 200.0}); }, "no row between", 0);
}

TEST(ReadImu, RejectsOtherUnits) {
  const auto row = [](double w, double f) {
    std::string text;
    for (int i = 0; i < 3; ++i) {
      text += FormatDouble(0.01 * i) + "," + FormatDouble(w) + ",0,0,0,0," + FormatDouble(f) + "\n";
    }
    return text;
  };
  ExpectInvalid([&] { Read(row(0, -1.0)); }, "is it in g?", 0);
  ExpectInvalid([&] { Read(row(0, -981.0)); }, "in mg or counts", 0);
  ExpectInvalid([&] { Read(row(0, -0.098)); }, "format: increments", 0);
  ExpectInvalid([&] { Read(row(0, 0.0)); }, "gravity removed", 0);
  ExpectInvalid([&] { Read(row(0, -9.8), {.format = ImuFormat::kIncrements}); }, "format: odyn", 0);
  ExpectInvalid([&] { Read(row(30.0, -9.8)); }, "deg/s", 0);
  EXPECT_NO_THROW(Read(row(1.0, -9.8)));
  EXPECT_NO_THROW(Read(row(0.0, -20.0)));
}

TEST(ReadImu, RejectsTimesInOtherUnits) {
  ExpectInvalid([] { Read("0,0,0,0,0,0,-9.8\n10,0,0,0,0,0,-9.8\n20,0,0,0,0,0,-9.8\n"); },
                "is the time in milliseconds? Divide it by 1000", 0);
  ExpectInvalid([] { Read("381000000,0,0,0,0,0,-9.8\n381000010,0,0,0,0,0,-9.8\n"); },
                "milliseconds? Divide it by 1000", 1);
}

TEST(ReadImu, RejectsImpossibleValuesByLine) {
  ExpectInvalid([] { Read("0,0,0,0,0,0,-9.8\n0.01,0,0,0,0,1e308,-9.8\n"); },
                "1e+308 is too large for an angular rate", 2);
}

TEST(SampleRange, CoversTheInterval) {
  const ImuData imu = Read(kFour);
  using Range = std::pair<std::size_t, std::size_t>;
  EXPECT_EQ(SampleRange(imu, 100.00, 100.02), Range(1, 3));
  EXPECT_EQ(SampleRange(imu, 100.001, 100.009), Range(1, 2));
  EXPECT_EQ(SampleRange(imu, 100.005, 100.015), Range(1, 3));
  EXPECT_EQ(SampleRange(imu, 0.0, 1e9), Range(0, 4));
  EXPECT_EQ(SampleRange(imu, 200.0, 300.0), Range(4, 4));
}

std::filesystem::path RealFile(const std::string& name) {
  return std::filesystem::path(DN_SHARED_DATA_DIR) / "data" / name / "IMU.txt";
}

TEST(ReadImu, RealFiles) {
  for (const char* name : {"walk", "thor75", "psins-car"}) {
    SCOPED_TRACE(name);
    if (!std::filesystem::exists(RealFile(name))) GTEST_SKIP() << RealFile(name) << " is absent";
    const ImuData imu = ReadImu(RealFile(name), {.sampling = ImuSampling::kInstantaneous});
    double sum = 0.0;
    for (const ImuSample& sample : imu.samples) sum += sample.f_b_mps2.norm();
    EXPECT_NEAR(sum / static_cast<double>(imu.samples.size()), 9.8, 0.8);
    // The tags of `walk` are written to 1 ms, at intervals of 6 to 9 ms: this is jitter, not gaps.
    EXPECT_TRUE(imu.gaps.empty());
    const Preintegrated pre =
        Preintegrate(imu, imu.t_begin_s(), imu.t_end_s(), {}, {1e-4, 1e-3, 1e-6});
    EXPECT_TRUE(pre.covariance.allFinite());
  }
}

}  // namespace dn::imu_test
