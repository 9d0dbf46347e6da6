// Measured point clouds outside this project; the tests are skipped if they are absent.
#include <dn/files/georeference_strip.h>
#include <dn/files/strip_files.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <map>

#include "files/read_all.h"
#include "testing/temp_folder.h"

namespace dn::files_test {

using testing::ReadAll;

namespace fs = std::filesystem;
using Eigen::Vector3d;

fs::path Data(const std::string& name) { return fs::path(DN_SHARED_DATA_DIR) / "data" / name; }

class Leeward : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(Data("leeward"))) GTEST_SKIP() << "no measured data: " << Data("leeward");
    trajectory_ = ReadTrajectory(Data("leeward/sbet.out"));
    frame_ = LocalFrame(trajectory_.points().front().position);
  }

  Trajectory trajectory_;
  LocalFrame frame_{Geodetic{}};
};

TEST_F(Leeward, TheSamePointsInUtmAndEcef) {
  const auto utm = OpenStrip(Data("leeward/points.las"));
  const auto ecef = OpenStrip(Data("leeward/points_ecef.las"));
  EXPECT_EQ(utm->crs().name, "utm:11n");  // a user-defined projection whose code contains the zone
  EXPECT_EQ(ecef->crs().name, "ecef");
  StripCloud a, b;
  ASSERT_TRUE(utm->Next(&a));
  ASSERT_TRUE(ecef->Next(&b));
  ASSERT_EQ(a.size(), 1325u);
  ASSERT_EQ(b.size(), 1325u);
  const PointCrs from_utm("utm:11n", frame_), from_ecef("ecef", frame_);
  for (std::size_t i = 0; i < a.size(); ++i) {
    // The coordinates of both files are rounded to 1 cm.
    EXPECT_LT((from_utm.ToMap(a.p_c[i]) - from_ecef.ToMap(b.p_c[i])).norm(), 0.02);
    EXPECT_EQ(a.t_s[i], b.t_s[i]);
  }
}

/// Slope and offset of the line through points, and the rms of the residuals.
struct Line {
  double offset = 0.0, slope = 0.0, rms = 0.0;
};

Line FitLine(const std::vector<Eigen::Vector2d>& points) {
  const auto n = static_cast<double>(points.size());
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const auto& point : points) mean += point / n;
  double xx = 0.0, xy = 0.0, rest2 = 0.0;
  for (const auto& point : points) {
    const Eigen::Vector2d d = point - mean;
    xx += d.x() * d.x();
    xy += d.x() * d.y();
  }
  Line line;
  line.slope = xy / xx;
  line.offset = mean.y() - line.slope * mean.x();
  for (const auto& point : points) {
    rest2 += std::pow(point.y() - line.offset - line.slope * point.x(), 2) / n;
  }
  line.rms = std::sqrt(rest2);
  return line;
}

// Checks trajectory, frames and the inverse equation with the data. Seen from the aircraft, the
// points must lie in the plane of a scanner, at the scan angles of the file.
TEST_F(Leeward, TheBeamsLieInOnePlaneAtTheirScanAngles) {
  const StripCloud points = ReadAll(Data("leeward/points_ecef.las"));
  const PointCrs crs("ecef", frame_);
  const std::vector<MapPose> poses = trajectory_.ToMapPoses(frame_);
  std::vector<Eigen::Vector2d> slopes;
  double sum_deg = 0.0, sum2_deg2 = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3d u_b =
        LaserVectorTo(InterpolatePose(poses, points.t_s[i]), Mounting(), crs.ToMap(points.p_c[i]));
    EXPECT_GT(u_b.norm(), 4400.0);
    EXPECT_LT(u_b.norm(), 5400.0);
    slopes.emplace_back(u_b.y() / u_b.z(), u_b.x() / u_b.z());
    const double rank_deg = static_cast<signed char>(points.records[i * points.record_bytes + 16]);
    const double rest_deg = rank_deg - std::atan2(u_b.y(), u_b.z()) * kDegPerRad;
    sum_deg += rest_deg / 1325.0;
    sum2_deg2 += rest_deg * rest_deg / 1325.0;
  }
  // Whole degrees have a standard deviation of 0.29.
  EXPECT_LT(std::abs(sum_deg), 0.15);
  EXPECT_LT(std::sqrt(sum2_deg2), 0.35);
  const Line line = FitLine(slopes);
  EXPECT_NEAR(std::atan(line.slope) * kDegPerRad, -14.0, 0.2);  // the scan line is oblique
  EXPECT_LT(std::abs(line.offset), 0.002);
  EXPECT_LT(line.rms * kDegPerRad, 0.006);
}

TEST_F(Leeward, ThereAndBackThroughAnotherBoresight) {
  const testing::TempFolder folder;
  const PointCrs crs("utm:11n", frame_);
  GeoreferenceOptions options;
  options.trajectory = trajectory_;
  options.mounting.boresight_rad = Vector3d(0.3, -0.2, 1.0) * kRadPerDeg;
  const auto quiet = [](std::uint64_t) {};
  const GeoreferencedStrip there =
      StripGeoreferencer(options, frame_, crs)
          .Run(Data("leeward/points.las"), folder.path() / "a.las", quiet);
  EXPECT_EQ(there.kept, 1325u);
  EXPECT_GT(there.shift_rms_m, 20.0);
  std::swap(options.made_with.mounting, options.mounting);
  StripGeoreferencer(options, frame_, crs)
      .Run(folder.path() / "a.las", folder.path() / "b.las", quiet);
  const StripCloud before = ReadAll(Data("leeward/points.las"));
  const StripCloud after = ReadAll(folder.path() / "b.las");
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_LT((before.p_c[i] - after.p_c[i]).cwiseAbs().maxCoeff(),
              0.0101);  // one step of the coordinate grid
    EXPECT_EQ(before.records.substr(i * 34 + 12, 22), after.records.substr(i * 34 + 12, 22));
  }
}

TEST(Bcts, ThreeStripsInOneFile) {
  const fs::path packed = Data("bcts/bcts_1.las.xz");
  if (!fs::exists(packed)) GTEST_SKIP() << "no measured data: " << packed;
  const testing::TempFolder folder;
  const fs::path file = folder.path() / "bcts_1.las";
  const std::string command = "xz -dc '" + packed.string() + "' > '" + file.string() + "'";
  if (std::system(command.c_str()) != 0) GTEST_SKIP() << "xz cannot unpack " << packed;
  struct Strip {
    std::size_t points = 0;
    double t_begin_s = 1e9, t_end_s = 0.0;
  };
  std::map<int, Strip> strips;
  const auto reader = OpenStrip(file);
  EXPECT_EQ(reader->points(), 531662u);
  for (StripCloud points; reader->Next(&points);) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      Strip& strip = strips[points.source[i]];
      ++strip.points;
      strip.t_begin_s = std::min(strip.t_begin_s, points.t_s[i]);
      strip.t_end_s = std::max(strip.t_end_s, points.t_s[i]);
    }
  }
  ASSERT_EQ(strips.size(), 3u);
  EXPECT_EQ(strips[66].points + strips[67].points + strips[68].points, 531662u);
  EXPECT_GT(strips[66].t_begin_s, 347063.0 - 1.0);
  EXPECT_LT(strips[66].t_end_s, 347087.0 + 1.0);
  EXPECT_GT(strips[68].t_begin_s, 347867.0 - 1.0);
}

TEST(Tent, TextStripsAreRead) {
  const std::vector<fs::path> files = FindStripFiles(Data("tent"));
  if (files.empty()) GTEST_SKIP() << "no measured data: " << Data("tent");
  ASSERT_EQ(files.size(), 2u);
  std::size_t points = 0;
  for (const fs::path& file : files) {
    const auto reader = OpenStrip(file);
    for (StripCloud chunk; reader->Next(&chunk);) points += chunk.size();
  }
  EXPECT_EQ(points, 84242u + 21978u);
}

}  // namespace dn::files_test
