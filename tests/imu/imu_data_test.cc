#include <dn/error.h>
#include <dn/geo/text_table.h>
#include <dn/imu/imu_data.h>
#include <dn/imu/preintegration.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "testing/expect_invalid.h"
#include "testing/temp_file.h"

namespace dn {
namespace {

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
  const ImuData imu = Read(kFour, {.body_is_flu = true});
  EXPECT_EQ(imu.samples[0].w_ib_b_radps, Vector3d(0.1, -0.2, -0.3));
  EXPECT_EQ(imu.samples[0].f_b_mps2, Vector3d(1, -2, 9.0));
}

// Rates are increments over the interval of each row; an odometer column is ignored.
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
  EXPECT_NEAR(imu.t_begin_s(), 100.00, 1e-12);  // of the sample that ends at 100.01
}

TEST(ReadImu, GapStaysVisible) {
  const std::string text = std::string(kFour) + "100.08, 0, 0, 0, 0, 0, -9.8\n";
  for (const ImuSampling sampling : {ImuSampling::kMean, ImuSampling::kInstantaneous}) {
    const ImuData imu = Read(text, {.sampling = sampling});
    ASSERT_EQ(imu.gaps.size(), 1u);
    EXPECT_NEAR(imu.gaps[0].t_begin_s, 100.03, 1e-12);
    EXPECT_NEAR(imu.gaps[0].t_end_s, 100.07, 1e-12);
    EXPECT_NEAR(imu.samples.back().dt_s, 0.01, 1e-12);
    EXPECT_EQ(imu.samples.back().f_b_mps2, Vector3d(0, 0, -9.8));  // not bridged
    EXPECT_LE(imu.max_jitter_s, 1e-12);
  }
}

// Tags of a coarse clock: the median, 0.006, is not the rate.
TEST(ReadImu, JitterIsNoGap) {
  const ImuData imu = Read(
      "408640.961,0,0,0,0,0,-9.8\n408640.967,0,0,0,0,0,-9.8\n408640.973,0,0,0,0,0,-9.8\n"
      "408640.9823,0,0,0,0,0,-9.8\n408640.9883,0,0,0,0,0,-9.8\n");
  EXPECT_TRUE(imu.gaps.empty());
  EXPECT_NEAR(imu.nominal_dt_s, 0.0273 / 4.0, 1e-9);
  EXPECT_NEAR(imu.samples[3].dt_s, 0.0093, 1e-9);
  EXPECT_NEAR(imu.max_jitter_s, 0.0093 - 0.0273 / 4.0, 1e-9);
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
  EXPECT_THROW(Read("0 0 0 0 0 0 -9.8 1\n0.01 0 0 0 0 0 -9.8 1\n"), InvalidInput);  // odyn: 7
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
    // walk's tags are written to 1 ms at intervals of 6 to 9 ms: jitter, not gaps.
    EXPECT_TRUE(imu.gaps.empty());
    const Preintegrated pre =
        Preintegrate(imu, imu.t_begin_s(), imu.t_end_s(), {}, {1e-4, 1e-3, 1e-6});
    EXPECT_TRUE(pre.covariance.allFinite());
  }
}

}  // namespace
}  // namespace dn
