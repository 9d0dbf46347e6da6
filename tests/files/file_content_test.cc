#include <dn/files/file_content.h>
#include <dn/geo/text_table.h>
#include <dn/geo/trajectory.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "testing/expect_invalid.h"
#include "testing/temp_folder.h"

namespace dn::files_test {

using testing::TempFolder;

/// Returns `count` rows whose first value is a time, step_s apart.
std::string Rows(double t_s, double step_s, const std::string& rest, int count = 30) {
  std::string text;
  for (int i = 0; i < count; ++i) text += FormatDouble(t_s + step_s * i) + ", " + rest + "\n";
  return text;
}

FileContent Look(const std::string& text, const std::string& name = "data.txt") {
  const TempFolder folder;
  folder.Write(name, text);
  return InspectFile(folder.path() / name);
}

TEST(FileContent, InertialDataByGravity) {
  const FileContent si = Look(Rows(100, 0.01, "0.01, 0.02, 0.3, 0.1, 0.2, -9.8"));
  EXPECT_EQ(si.kind, FileKind::kImu);
  EXPECT_EQ(si.imu_format, ImuFormat::kOdyn);
  EXPECT_FALSE(si.rates_in_deg || si.forces_in_g);
  const FileContent own = Look(Rows(100, 0.01, "1, 2, 20, 0.1, 0.2, 0.98"));
  EXPECT_EQ(own.kind, FileKind::kImu);
  EXPECT_TRUE(own.rates_in_deg && own.forces_in_g);
  const FileContent increments = Look(Rows(100, 0.005, "1e-4, 2e-4, 1e-3, 1e-3, 0, -0.049, 7"));
  EXPECT_EQ(increments.kind, FileKind::kImu);
  EXPECT_EQ(increments.imu_format, ImuFormat::kIncrements);
  EXPECT_FALSE(increments.rates_in_deg);
}

TEST(FileContent, GnssByItsColumns) {
  const FileContent plain = Look(Rows(100, 1, "46.5, 6.5, 400"));
  EXPECT_EQ(plain.kind, FileKind::kGnss);
  EXPECT_FALSE(plain.has_sigma || plain.has_velocity);
  const FileContent sigmas = Look(Rows(100, 0.2, "46.5, 6.5, 400, 0.01, 0.01, 0.02"));
  EXPECT_EQ(sigmas.kind, FileKind::kGnss);
  EXPECT_TRUE(sigmas.has_sigma);
  const FileContent both =
      Look(Rows(100, 1, "46.5, 6.5, 400, 0.1, 0.1, 0.2, 1, -2, 0.1, 0.01, 0.01, 0.02"));
  EXPECT_EQ(both.gnss_format, GnssFormat::kOdyn);
  EXPECT_TRUE(both.has_sigma && both.has_velocity);
  const FileContent gins =
      Look(Rows(100, 1, "46.5, 6.5, 400, 1, -2, 0.1, 0.1, 0.1, 0.2, 0.01, 0.01, 0.02"));
  EXPECT_EQ(gins.gnss_format, GnssFormat::kObGins);
  EXPECT_EQ(Look("%  GPST  latitude(deg)\n").gnss_format, GnssFormat::kRtklib);
}

TEST(FileContent, PairsAndTrajectories) {
  EXPECT_EQ(Look(Rows(100, 0, "130, 1, 2, 30, 3, 4, 30")).kind, FileKind::kPairs);
  EXPECT_EQ(Look(Rows(100, 1, "46.5, 6.5, 400, 0.5, 0.5, -0.5, 0.5")).kind, FileKind::kTrajectory);
  std::vector<NavPoint> points;
  for (int i = 0; i < 20; ++i) {
    points.push_back({.t_s = 100.0 + i, .position = {0.8, 0.1, 400.0}});
  }
  const std::string sbet = FormatSbet(points);
  EXPECT_EQ(Look(sbet, "a.out").kind, FileKind::kTrajectory);
  for (const char* name : {"SBET_MISSION.OUT", "a.SBET", "a.Out", "a.bin", "a.txt"}) {
    EXPECT_EQ(Look(sbet, name).kind, FileKind::kTrajectory) << name;
  }
  EXPECT_EQ(Look(sbet.substr(1), "a.out").kind, FileKind::kUnknown);
}

using Attitude = TrajectoryColumns::Attitude;

/// Returns the quaternion or angles of a level body with this heading, with a small drift to the
/// side.
std::string AttitudeText(double heading_rad, Attitude attitude, bool flu) {
  const double heading_deg = (heading_rad + 0.1) * kDegPerRad;
  if (attitude == Attitude::kRollPitchHeading) return fmt::format("1, -2, {}", heading_deg);
  if (attitude == Attitude::kRollPitchYawEnu) return fmt::format("1, -2, {}", 90.0 - heading_deg);
  const bool enu = attitude == Attitude::kQuaternionEnu;
  const double turn = enu ? std::numbers::pi / 2.0 - heading_rad - 0.1 : heading_rad + 0.1;
  Eigen::Quaterniond q(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()));
  if (enu != flu) q = q * Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX());
  return fmt::format("{}, {}, {}, {}", q.w(), q.x(), q.y(), q.z());
}

std::string PositionText(const std::string& crs, double east_m, double north_m) {
  if (crs == "utm:") return fmt::format("{:.3f}, {:.3f}, 900", 431000 + east_m, 5190000 + north_m);
  if (crs == "map") return fmt::format("{:.3f}, {:.3f}, 900", east_m, north_m);
  const Geodetic at{0.82 + north_m / 6.38e6, 0.11 + east_m / 6.38e6 / std::cos(0.82), 900.0};
  if (crs == "geographic") {
    return fmt::format("{:.9f}, {:.9f}, 900", at.lat_rad * kDegPerRad, at.lon_rad * kDegPerRad);
  }
  const Eigen::Vector3d p = ToEcef(at);
  return fmt::format("{:.3f}, {:.3f}, {:.3f}", p.x(), p.y(), p.z());
}

/// Returns a trajectory that is at rest on the ground and then flies a curve at 60 m/s.
std::string TrajectoryText(const std::string& crs, Attitude attitude, bool flu, int still = 0) {
  std::string text;
  double east_m = 10.0, north_m = 20.0;
  for (int i = 0; i < still + 400; ++i) {
    const double heading = 0.7 + 0.01 * std::max(0, i - still);
    if (i > still) {
      east_m += 6.0 * std::sin(heading);
      north_m += 6.0 * std::cos(heading);
    }
    text += fmt::format("{:.2f}, {}, {}\n", 3000.0 + 0.1 * i, PositionText(crs, east_m, north_m),
                        AttitudeText(heading, attitude, flu));
  }
  return text;
}

TEST(FileContent, CoordinatesAndAttitudeOfATrajectory) {
  for (const char* crs : {"geographic", "utm:", "map", "ecef"}) {
    for (const Attitude attitude : {Attitude::kQuaternionNed, Attitude::kQuaternionEnu,
                                    Attitude::kRollPitchHeading, Attitude::kRollPitchYawEnu}) {
      SCOPED_TRACE(std::string(crs) + std::to_string(static_cast<int>(attitude)));
      const FileContent content = Look(TrajectoryText(crs, attitude, false));
      ASSERT_EQ(content.kind, FileKind::kTrajectory);
      EXPECT_EQ(content.trajectory->crs, crs);
      EXPECT_EQ(content.trajectory->attitude, attitude);
      EXPECT_FALSE(content.trajectory->body_is_flu);
    }
  }
  for (const Attitude attitude : {Attitude::kQuaternionNed, Attitude::kQuaternionEnu}) {
    const FileContent content = Look(TrajectoryText("geographic", attitude, true));
    EXPECT_EQ(content.trajectory->attitude, attitude);
    EXPECT_TRUE(content.trajectory->body_is_flu);
  }
}

// The trajectory has more rows at rest than the rows that are normally read.
TEST(FileContent, ATrajectoryThatStandsAtFirst) {
  const FileContent content = Look(TrajectoryText("utm:", Attitude::kRollPitchYawEnu, false, 5000));
  ASSERT_EQ(content.kind, FileKind::kTrajectory);
  EXPECT_EQ(content.trajectory->attitude, Attitude::kRollPitchYawEnu);
}

TEST(FileContent, ALongTrajectoryThatStandsAtFirst) {
  const FileContent content =
      Look(TrajectoryText("utm:", Attitude::kRollPitchYawEnu, false, 120000));
  ASSERT_EQ(content.kind, FileKind::kTrajectory);
  EXPECT_EQ(content.trajectory->attitude, Attitude::kRollPitchYawEnu);
}

TEST(FileContent, PositionsWithSigmasThatMoveNorthAreNoTrajectory) {
  std::string text;
  for (int i = 0; i < 400; ++i) {
    text += fmt::format("{}, {:.9f}, 6.5, 900, 0.01, 0.01, 0.02\n", 3000 + i, 46.5 + 5e-4 * i);
  }
  EXPECT_EQ(Look(text).kind, FileKind::kGnss);
}

TEST(FileContent, PointClouds) {
  EXPECT_EQ(Look(std::string("LASF\0\0\1\2", 8), "strip.las").kind, FileKind::kPointCloud);
}

TEST(FileContent, TimeSince1980And1970) {
  // Week 2347 begins 1419465600 s after the start of 1980; GPS time is 18 leap seconds ahead of
  // Unix time.
  const std::string rest = "0.01, 0.02, 0.3, 0.1, 0.2, -9.8";
  EXPECT_EQ(Look(Rows(100, 0.01, rest)).time_offset_s, 0.0);
  EXPECT_EQ(Look(Rows(1419465700, 0.01, rest)).time_offset_s, 1419465600.0);
  EXPECT_EQ(Look(Rows(1419465700.0 + 315964800 - 18, 0.01, rest)).time_offset_s,
            1419465600.0 + 315964800 - 18);
}

TEST(FileContent, WhatIsNoneOfThemSaysWhy) {
  EXPECT_EQ(Look("").why, "empty");
  EXPECT_THAT(Look("time,x,y\n1,2,3\n").why, ::testing::HasSubstr("3 columns"));
  EXPECT_THAT(Look("hello world\n").why, ::testing::HasSubstr("no line has numbers"));
  EXPECT_THAT(Look(Rows(1, 1, "2, 3")).why, ::testing::HasSubstr("3 columns"));
  EXPECT_EQ(InspectFile("/nowhere/at/all").kind, FileKind::kUnknown);
}

TEST(FileContent, AFolderInOrderWithoutWhatIsWrittenByUs) {
  const TempFolder folder;
  folder.Write("b.txt", Rows(100, 1, "46.5, 6.5, 400"));
  folder.Write("a.txt", Rows(100, 0.01, "0.01, 0.02, 0.3, 0.1, 0.2, -9.8"));
  folder.Write("flight.yaml", "name: x\n");
  folder.Write("reference.txt", "1\n");
  const std::vector<FileContent> contents = InspectFolder(folder.path());
  ASSERT_EQ(contents.size(), 2u);
  EXPECT_EQ(contents[0].kind, FileKind::kImu);
  EXPECT_EQ(contents[1].kind, FileKind::kGnss);
}

TEST(FileContent, WhatIsNoFileInAFolderSaysWhy) {
  const TempFolder folder;
  folder.Write("a.txt", Rows(100, 1, "46.5, 6.5, 400"));
  std::filesystem::create_directory(folder.path() / "folder");
  std::filesystem::create_symlink("loop.txt", folder.path() / "loop.txt");
  std::filesystem::create_symlink("nowhere", folder.path() / "lost.txt");
  ASSERT_EQ(mkfifo((folder.path() / "pipe.txt").c_str(), 0600), 0);
  const std::vector<FileContent> contents = InspectFolder(folder.path());
  ASSERT_EQ(contents.size(), 4u);
  EXPECT_EQ(contents[0].kind, FileKind::kGnss);
  EXPECT_THAT(contents[1].why, ::testing::HasSubstr("symbolic links"));
  EXPECT_THAT(contents[2].why, ::testing::HasSubstr("does not exist"));
  EXPECT_THAT(contents[3].why, ::testing::HasSubstr("a named pipe"));
}

}  // namespace dn::files_test
