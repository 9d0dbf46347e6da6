// ASCII logs of NovAtel receivers: the message names decide on kind and columns.
#include <dn/files/file_content.h>
#include <dn/geo/local_frame.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "testing/temp_folder.h"

namespace dn::files_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string LongHeader(const std::string& name, double t_s) {
  return fmt::format("#{},COM1,0,55.0,FINESTEERING,2280,{:.3f},02000020,b1f6,16809;", name, t_s);
}

std::string ShortHeader(const std::string& name, double t_s) {
  return fmt::format("%{},2280,{:.3f};", name, t_s);
}

/// Returns increments at 200 Hz of a body at rest, z up, in counts.
std::string RawImu(double t_s, double counts_per_mps) {
  const long up = std::lround(9.80665 / 200.0 * counts_per_mps);
  return fmt::format("2280,{:.9f},77000000,{},{},31,12,-3,4*aabbccdd\r\n", t_s, up,
                     t_s > 381005.0 ? 20 : -20);
}

std::string BestPosition(const std::string& name, double t_s, const std::string& type) {
  return LongHeader(name, t_s) +
         fmt::format(
             "SOL_COMPUTED,{},46.57,{:.9f},300.1,50.25,WGS84,0.01,0.02,0.03,\"\",1.0,0.0,"
             "25,25,25,25,0,06,39,33*d3bf4c0a\r\n",
             type, 6.52 + 1e-5 * (t_s - 381000.0));
}

std::string InsPva(double t_s, const std::string& status) {
  return ShortHeader("INSPVASA", t_s) +
         fmt::format("2280,{:.9f},46.57,6.52,350.1,0.1,25.0,0.2,-1.5,2.5,91.5,{}*aabbccdd\r\n", t_s,
                     status);
}

std::string SpanLog(const std::string& position = "BESTGNSSPOSA") {
  std::string text = "[COM1]<OK\r\n";
  for (int i = 0; i < 2000; ++i) {
    const double t_s = 381000.0 + 0.005 * i;
    text += ShortHeader("RAWIMUSA", t_s) + RawImu(t_s, 1.0 / (0x1p-27 * 0.3048));
    if (i % 20 == 0) text += InsPva(t_s, "INS_SOLUTION_GOOD");
    if (i % 200 == 0) text += BestPosition(position, t_s, "NARROW_INT");
  }
  return text;
}

std::vector<FileContent> InspectLog(const std::string& text) {
  const testing::TempFolder folder;
  folder.Write("span.asc", text);
  return InspectFolder(folder.path());
}

const FileContent* Find(const std::vector<FileContent>& contents, FileKind kind) {
  const auto found = std::find_if(contents.begin(), contents.end(),
                                  [&](const FileContent& each) { return each.kind == kind; });
  return found == contents.end() ? nullptr : &*found;
}

TEST(MessageLog, HasSeveralKindsOfData) {
  const testing::TempFolder folder;
  folder.Write("span.asc", SpanLog());
  const std::vector<FileContent> contents = InspectFolder(folder.path());
  ASSERT_EQ(contents.size(), 3u);
  const FileContent* imu = Find(contents, FileKind::kImu);
  ASSERT_NE(imu, nullptr);
  EXPECT_THAT(imu->columns, ElementsAre("=RAWIMUSA", "skip", "skip", "week", "t", "skip", "fz",
                                        "-fy", "fx", "wz", "-wy", "wx"));
  ImuReadOptions options{.format = imu->imu_format, .columns = imu->columns};
  options.rate_unit_radps = imu->rate_unit;
  options.force_unit_mps2 = imu->force_unit;
  const ImuData data = ReadImu(imu->file, options);
  EXPECT_NEAR(data.samples.back().f_b_mps2.z(), 9.80665, 1e-4);
  EXPECT_NEAR(data.samples.back().w_ib_b_radps.y(), 200.0 * 3.0 * 0x1p-33, 1e-12);
  EXPECT_NEAR(data.nominal_dt_s, 0.005, 1e-9);
  const FileContent* gnss = Find(contents, FileKind::kGnss);
  ASSERT_NE(gnss, nullptr);
  GnssColumns columns;
  columns.names = gnss->columns;
  const GnssData positions = ReadGnss(gnss->file, gnss->gnss_format, 0.0, columns);
  ASSERT_EQ(positions.epochs.size(), 10u);
  EXPECT_NEAR(positions.epochs[0].antenna.h_m, 350.35, 1e-9);  // above the ellipsoid
  EXPECT_NEAR((*positions.epochs[0].covariance_enu_m2)(0, 0), 0.02 * 0.02, 1e-12);
  EXPECT_EQ(positions.epochs[1].t_s, 381001.0);
  EXPECT_NE(Find(contents, FileKind::kTrajectory), nullptr);
}

TEST(MessageLog, ATrajectoryOfTheReceiver) {
  std::string log;
  for (int i = 0; i < 100; ++i) {
    log += InsPva(381000.0 + 0.01 * i, i < 10 ? "INS_ALIGNING" : "INS_SOLUTION_GOOD");
  }
  const testing::TempFolder folder;
  folder.Write("span.asc", log);
  const FileContent content = InspectFile(folder.path() / "span.asc");
  ASSERT_EQ(content.kind, FileKind::kTrajectory) << content.why;
  const TextTable table =
      ReadNamedColumns(content.file, content.columns, TrajectoryQuantities(false));
  EXPECT_EQ(table.rows(), 90u);
  EXPECT_EQ(table.row(0)[6], 91.5);
  EXPECT_THAT(content.why, HasSubstr("real time"));
}

TEST(MessageLog, TheSizeOfACountFollowsFromGravity) {
  const auto inspect = [](const std::string& name, double counts_per_mps) {
    std::string log;
    for (int i = 0; i < 400; ++i) {
      const double t_s = 381000.0 + 0.005 * i;
      log += name.ends_with("SA") ? ShortHeader(name, t_s) : LongHeader(name, t_s);
      log += RawImu(t_s, counts_per_mps);
    }
    return InspectLog(log).front();
  };
  EXPECT_EQ(inspect("RAWIMUA", 1.0 / 0x1p-29).rate_unit, 0x1p-33);
  EXPECT_EQ(inspect("RAWIMUSA", 1.0 / 0x1p-14).rate_unit, 0x1p-19);
  EXPECT_EQ(inspect("RAWIMUSA", 1.0 / 0x1p-22).force_unit, 0x1p-22);
  EXPECT_EQ(inspect("RAWIMUSA", 1.0 / 2e-8).rate_unit, 1e-9);
  const FileContent unknown = inspect("RAWIMUSA", 1e3);
  EXPECT_EQ(unknown.kind, FileKind::kUnknown);
  EXPECT_THAT(unknown.why, AllOf(HasSubstr("imu.force_unit"), HasSubstr("=RAWIMUSA")));
}

TEST(MessageLog, PositionsWithInertialDataAreNotGnss) {
  std::string log = BestPosition("BESTPOSA", 381000.0, "INS_RTKFIXED");
  log += BestPosition("BESTPOSA", 381001.0, "INS_RTKFIXED");
  const FileContent content = InspectLog(log).front();
  EXPECT_EQ(content.kind, FileKind::kUnknown);
  EXPECT_THAT(content.why, HasSubstr("log BESTGNSSPOS"));
  EXPECT_NE(Find(InspectLog(SpanLog("BESTPOSA")), FileKind::kGnss), nullptr);
  EXPECT_NE(Find(InspectLog(SpanLog("BESTGPSPOSA")), FileKind::kGnss), nullptr);
}

TEST(MessageLog, NmeaReplacesMissingPositions) {
  const std::string log =
      "$GPGGA,094942.00,4630.0,N,00630.0,E,4,12,0.8,450.0,M,50.0,M,1.0,0001\r\n" +
      InsPva(381000.0, "INS_SOLUTION_GOOD") + InsPva(381000.1, "INS_SOLUTION_GOOD");
  const std::vector<FileContent> contents = InspectLog(log);
  ASSERT_NE(Find(contents, FileKind::kGnss), nullptr);
  EXPECT_EQ(Find(contents, FileKind::kGnss)->gnss_format, GnssFormat::kNmea);
}

TEST(MessageLog, OtherTextsAreNoLogs) {
  const FileContent content = InspectLog("#comment,1;2\n1 46.5 6.5 400\n2 46.5 6.5 400\n").front();
  EXPECT_EQ(content.kind, FileKind::kGnss);
  EXPECT_THAT(content.columns, IsEmpty());
}

}  // namespace dn::files_test
