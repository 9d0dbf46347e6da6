#include <dn/files/georeference_strip.h>
#include <dn/files/strip_source.h>
#include <dn/geo/read_file.h>
#include <dn/geo/text_table.h>
#include <dn/lidar/point_covariance.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "files/read_all.h"
#include "testing/earth_motion.h"
#include "testing/expect_invalid.h"
#include "testing/las_bytes.h"
#include "testing/temp_folder.h"

namespace dn::files_test {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing::EarthMotion;
using testing::ExpectInvalidIn;
using testing::LasBytes;
using testing::ReadAll;
using testing::TempFolder;
namespace fs = std::filesystem;

constexpr double kBegin_s = 381000.0, kEnd_s = 381020.0;
constexpr double kGridM = 1e-4;
const auto kNoProgress = [](std::uint64_t) {};

/// Twenty seconds of a survey aircraft with a scanner that looks at the ground below.
struct Survey {
  EarthMotion motion = testing::PlaneMotion();
  Mounting mounting;

  Survey() {
    mounting.R_bs_nominal << 0, 1, 0, 0, 0, 1, 1, 0, 0;
    mounting.lever_arm_b_m = Vector3d(0.14, -0.02, 0.21);
    mounting.boresight_rad = Vector3d(0.2, 0.03, 0.35) * kRadPerDeg;
  }

  Trajectory Flown(double from_s = kBegin_s, double to_s = kEnd_s) const {
    std::vector<NavPoint> points;
    for (int k = 0; k <= 100 * (to_s - from_s); ++k) {
      const double t_s = from_s + 0.01 * k;
      MapPose pose = motion.Pose(t_s - kBegin_s);
      pose.t_s = t_s;
      points.push_back(ToNavPoint(pose, motion.frame));
    }
    return Trajectory(points);
  }

  static Vector3d Beam(double t_s) {
    return {700.0 + 5.0 * std::sin(t_s), 3.0, 300.0 * std::sin(7.0 * t_s)};
  }

  /// Computes the ground point with matrices, independent of the equation of the library.
  Vector3d Ground(double t_s, const Vector3d& boresight_rad) const {
    const MapPose pose = motion.Pose(t_s - kBegin_s);
    const double angle = boresight_rad.norm();
    const Matrix3d boresight =
        angle > 0.0 ? Eigen::AngleAxisd(angle, boresight_rad / angle).toRotationMatrix()
                    : Matrix3d(Matrix3d::Identity());
    const Vector3d u_b = boresight * mounting.R_bs_nominal * Beam(t_s);
    return pose.p_mb + pose.q_mb.toRotationMatrix() * (u_b + mounting.lever_arm_b_m);
  }

  GeoreferenceOptions Options() const {
    GeoreferenceOptions options;
    options.trajectory = Flown();
    options.mounting = options.made_with.mounting = mounting;
    return options;
  }
};

std::vector<double> Epochs(int count, double from_s = kBegin_s + 1.0, double step_s = 0.37) {
  std::vector<double> t_s;
  for (int i = 0; i < count; ++i) t_s.push_back(from_s + step_s * i);
  return t_s;
}

/// Returns a LAS file without laser vectors.
std::string Las(const Survey& survey, const PointCrs& crs, const std::vector<double>& epochs_s) {
  LasBytes las;
  las.minor = 4;
  las.format = 6;
  las.scale = kGridM;
  const Vector3d first =
      crs.FromMap(survey.Ground(epochs_s.front(), Vector3d::Zero())).array().round();
  for (int i = 0; i < 3; ++i) las.offset[i] = first[i];
  for (const double t_s : epochs_s) {
    const Vector3d p_c = crs.FromMap(survey.Ground(t_s, survey.mounting.boresight_rad));
    const auto steps = [&](int i) {
      return static_cast<std::int32_t>(std::lround((p_c[i] - first[i]) / kGridM));
    };
    las.points.push_back({steps(0), steps(1), steps(2), t_s, 100, 3, 1, ""});
  }
  return las.Build();
}

/// Returns a text file with laser vectors and meaningless coordinates.
std::string Text(const std::vector<double>& epochs_s) {
  std::string text;
  for (const double t_s : epochs_s) {
    const Vector3d u_s = Survey::Beam(t_s);
    text += FormatDouble(t_s) + ", 1, 2, 3, " + FormatDouble(u_s.x()) + ", " +
            FormatDouble(u_s.y()) + ", " + FormatDouble(u_s.z()) + "\n";
  }
  return text;
}

class GeoreferenceStrip : public ::testing::Test {
 protected:
  GeoreferencedStrip Run(const GeoreferenceOptions& options, const std::string& crs,
                         const std::string& name) const {
    return StripGeoreferencer(options, survey_.motion.frame, PointCrs(crs, survey_.motion.frame))
        .Run(folder_.path() / name, Out(name), kNoProgress);
  }
  fs::path Out(const std::string& name) const { return folder_.path() / ("new_" + name); }

  /// Returns a LAS file in map whose time tags are early.
  std::string EarlyLas(const std::vector<double>& epochs_s, double early_s) const {
    constexpr std::size_t kRecord = 30, kTimeAt = 22;
    std::string las = Las(survey_, PointCrs("map", survey_.motion.frame), epochs_s);
    std::size_t at = las.size() - kRecord * epochs_s.size() + kTimeAt;
    for (const double t_s : epochs_s) {
      LasBytes::Put(t_s - early_s, at, &las);
      at += kRecord;
    }
    return las;
  }

  Survey survey_;
  TempFolder folder_;
};

TEST_F(GeoreferenceStrip, ANewBoresightMovesLasPointsWhereItSays) {
  const std::vector<double> epochs_s = Epochs(40);
  for (const char* name : {"map", "utm:32n", "ecef", "epsg:2056", "epsg:25832 heights:ft"}) {
    SCOPED_TRACE(name);
    const PointCrs crs(name, survey_.motion.frame);
    folder_.Write("strip.las", Las(survey_, crs, epochs_s));
    GeoreferenceOptions options = survey_.Options();
    options.mounting.boresight_rad = Vector3d(-0.1, 0.2, 0.5) * kRadPerDeg;
    const GeoreferencedStrip strip = Run(options, name, "strip.las");
    EXPECT_EQ(strip.points, 40u);
    EXPECT_EQ(strip.kept, 40u);
    EXPECT_EQ(strip.origin.kind, VectorOrigin::Kind::kAssumed);
    EXPECT_GT(strip.shift_rms_m, 1.0);
    EXPECT_GE(strip.shift_max_m, strip.shift_rms_m);
    const StripCloud points = ReadAll(Out("strip.las"));
    for (std::size_t i = 0; i < epochs_s.size(); ++i) {
      const Vector3d truth_m = survey_.Ground(epochs_s[i], options.mounting.boresight_rad);
      EXPECT_LT((crs.ToMap(points.p_c[i]) - truth_m).norm(), 3.0 * kGridM);
    }
    EXPECT_EQ(points.t_s, epochs_s);
    EXPECT_EQ(points.source, std::vector<std::uint16_t>(40, 3));
  }
}

TEST_F(GeoreferenceStrip, NothingNewLeavesTheFileAsItWas) {
  const PointCrs crs("utm:32n", survey_.motion.frame);
  folder_.Write("strip.las", Las(survey_, crs, Epochs(20)));
  const GeoreferencedStrip strip = Run(survey_.Options(), "utm:32n", "strip.las");
  EXPECT_LT(strip.shift_max_m, 1e-6);
  EXPECT_EQ(ReadWholeFile(Out("strip.las")), ReadWholeFile(folder_.path() / "strip.las"));
}

TEST_F(GeoreferenceStrip, ACompressedStripStaysCompressed) {
  constexpr std::size_t kFormatAt = 104;
  const PointCrs crs("utm:32n", survey_.motion.frame);
  folder_.Write("strip.las", Las(survey_, crs, Epochs(40)));
  const auto plain = OpenStrip(folder_.path() / "strip.las");
  const auto writer = plain->MakeWriter(folder_.path() / "strip.laz", {});
  for (StripCloud points; plain->Next(&points);) writer->Append(points);
  writer->Finish();
  GeoreferenceOptions options = survey_.Options();
  options.mounting.boresight_rad = Vector3d(-0.1, 0.2, 0.5) * kRadPerDeg;
  EXPECT_GT(Run(options, "utm:32n", "strip.las").shift_rms_m, 1.0);
  Run(options, "utm:32n", "strip.laz");
  EXPECT_EQ(ReadAll(Out("strip.laz")).records, ReadAll(Out("strip.las")).records);
  EXPECT_EQ(ReadWholeFile(Out("strip.laz"))[kFormatAt], static_cast<char>(0x80 | 6));
}

TEST_F(GeoreferenceStrip, TextHasItsOwnVectors) {
  const std::vector<double> epochs_s = Epochs(20);
  folder_.Write("strip.txt", Text(epochs_s));
  GeoreferenceOptions options = survey_.Options();
  options.made_with.mounting = Mounting();  // has no influence
  const GeoreferencedStrip strip = Run(options, "map", "strip.txt");
  EXPECT_EQ(strip.origin.kind, VectorOrigin::Kind::kMeasured);
  const StripCloud points = ReadAll(Out("strip.txt"));
  for (std::size_t i = 0; i < epochs_s.size(); ++i) {
    EXPECT_LT((points.p_c[i] - survey_.Ground(epochs_s[i], survey_.mounting.boresight_rad)).norm(),
              1e-6);
    EXPECT_EQ(points.u_s[i], Survey::Beam(epochs_s[i]));
  }
}

TEST_F(GeoreferenceStrip, TheErrorsOfBeamsAreTakenOut) {
  const std::string row = FormatDouble(kBegin_s + 1.0) + ", 1, 2, 3, 700, 3, 10";
  folder_.Write("strip.txt", row + ", 1\n");
  folder_.Write("plain.txt", row + "\n");
  GeoreferenceOptions options = survey_.Options();
  options.beams = BeamErrors{Vector3d::UnitY(), {0.0, 0.01}, {0.0, 2.0}};
  Run(options, "map", "strip.txt");
  const Vector3d u_s = options.beams->Remove({700, 3, 10}, 1);
  EXPECT_NEAR(u_s.norm(), Vector3d(700, 3, 10).norm() - 2.0, 1e-9);
  const MapPose pose = options.trajectory.MapPoseAt(kBegin_s + 1.0, survey_.motion.frame);
  EXPECT_LT((ReadAll(Out("strip.txt")).p_c[0] - Georeference(pose, survey_.mounting, u_s)).norm(),
            1e-6);
  ExpectInvalidIn([&] { Run(options, "map", "plain.txt"); }, "no laser vectors with beams",
                  "plain.txt");
}

TEST_F(GeoreferenceStrip, AKnownOffsetOfTheTagsIsTakenOut) {
  std::vector<double> tags_s = Epochs(20);
  std::string text;
  constexpr double kOffsetS = 0.25;
  for (double& t_s : tags_s) {
    const Vector3d u_s = Survey::Beam(t_s);
    t_s += kOffsetS;
    text += FormatDouble(t_s) + ", 1, 2, 3, " + FormatDouble(u_s.x()) + ", " +
            FormatDouble(u_s.y()) + ", " + FormatDouble(u_s.z()) + "\n";
  }
  folder_.Write("strip.txt", text);
  GeoreferenceOptions options = survey_.Options();
  options.time_offset_s = kOffsetS;
  Run(options, "map", "strip.txt");
  const StripCloud points = ReadAll(Out("strip.txt"));
  for (std::size_t i = 0; i < tags_s.size(); ++i) {
    const Vector3d truth_m = survey_.Ground(tags_s[i] - kOffsetS, survey_.mounting.boresight_rad);
    EXPECT_LT((points.p_c[i] - truth_m).norm(), 1e-6);
  }
  EXPECT_EQ(points.t_s, tags_s);
}

// Time tags in UTC, or of another clock: the points lie along the course from where the trajectory
// puts them.
TEST_F(GeoreferenceStrip, AnotherClockIsNamed) {
  const std::vector<double> epochs_s = Epochs(2000, kBegin_s + 1.0, 0.009);
  std::string text;
  for (const double t_s : epochs_s) {
    const Vector3d p_m = survey_.Ground(t_s, survey_.mounting.boresight_rad);
    const Vector3d u_s = Survey::Beam(t_s);
    text += FormatDouble(t_s - 8.0);
    for (const Vector3d& v : {p_m, u_s}) {
      for (const double x : v) text += ", " + FormatDouble(x);
    }
    text += "\n";
  }
  folder_.Write("strip.txt", text);
  folder_.Write("strip.las", EarlyLas(epochs_s, 8.0));
  GeoreferenceOptions options = survey_.Options();
  options.trajectory = survey_.Flown(kBegin_s - 10.0, kEnd_s);
  for (const char* name : {"strip.txt", "strip.las"}) {
    ExpectInvalidIn([&] { Run(options, "map", name); }, " s early; set lidar.time_offset_s: -",
                    name);
    options.time_offset_s = -8.0;
    EXPECT_EQ(Run(options, "map", name).kept, epochs_s.size());
    options.time_offset_s = 0.0;
  }
}

TEST_F(GeoreferenceStrip, EighteenSecondsAreUtc) {
  const std::vector<double> epochs_s = Epochs(2000, kBegin_s + 1.0, 0.009);
  folder_.Write("strip.las", EarlyLas(epochs_s, 18.0));
  GeoreferenceOptions options = survey_.Options();
  options.trajectory = survey_.Flown(kBegin_s - 20.0, kEnd_s);
  ExpectInvalidIn([&] { Run(options, "map", "strip.las"); },
                  "18 s early: are they in UTC? Set lidar.time_offset_s: -18", "strip.las");
}

TEST_F(GeoreferenceStrip, ANewTrajectoryTakesTheVectorsOfTheOldOne) {
  const PointCrs crs("map", survey_.motion.frame);
  const std::vector<double> epochs_s = Epochs(20);
  folder_.Write("strip.las", Las(survey_, crs, epochs_s));
  GeoreferenceOptions options = survey_.Options();
  Survey shifted = survey_;
  shifted.motion.position_m.offset += Vector3d(1.0, -2.0, 0.5);
  options.made_by = std::exchange(options.trajectory, shifted.Flown());
  Run(options, "map", "strip.las");
  const StripCloud points = ReadAll(Out("strip.las"));
  for (std::size_t i = 0; i < epochs_s.size(); ++i) {
    EXPECT_LT((points.p_c[i] - shifted.Ground(epochs_s[i], survey_.mounting.boresight_rad)).norm(),
              3.0 * kGridM);
  }
}

TEST_F(GeoreferenceStrip, PointsWithoutAPoseAreDroppedByReason) {
  std::vector<NavPoint> points;
  for (const auto& [from_s, to_s] : {std::pair{kBegin_s, 381008.0}, std::pair{381012.0, kEnd_s}}) {
    const std::vector<NavPoint> part = survey_.Flown(from_s, to_s).points();
    points.insert(points.end(), part.begin(), part.end());
  }
  GeoreferenceOptions options = survey_.Options();
  options.trajectory = Trajectory(points);
  options.time_span_s = Eigen::Vector2d(kBegin_s - 0.5, kEnd_s + 2.0);
  folder_.Write("strip.txt", Text(Epochs(24, kBegin_s - 1.5, 1.0)));  // from -1.5 to 21.5 s
  const GeoreferencedStrip strip = Run(options, "map", "strip.txt");
  EXPECT_EQ(strip.points, 24u);
  EXPECT_EQ(strip.kept, 16u);
  const std::map<std::string, std::uint64_t> expected{{"after the trajectory", 2},
                                                      {"before the trajectory", 1},
                                                      {"in trajectory gaps", 4},
                                                      {"outside time span", 1}};
  EXPECT_EQ(strip.dropped, expected);
  EXPECT_EQ(ReadAll(Out("strip.txt")).size(), 16u);
}

TEST_F(GeoreferenceStrip, ThePointsOfAFileNeedTheTrajectoryThatMadeThem) {
  const PointCrs crs("map", survey_.motion.frame);
  folder_.Write("strip.las", Las(survey_, crs, Epochs(20, kBegin_s + 0.5, 0.5)));
  GeoreferenceOptions options = survey_.Options();
  options.made_by = survey_.Flown(kBegin_s, kBegin_s + 5.2);
  const GeoreferencedStrip strip = Run(options, "map", "strip.las");
  EXPECT_EQ(strip.kept, 10u);
  EXPECT_EQ(strip.dropped.at("outside the trajectory of the points"), 10u);
}

TEST_F(GeoreferenceStrip, TheWeekOfTheTrajectoryCounts) {
  folder_.Write("strip.txt", Text(Epochs(5)));
  GeoreferenceOptions options = survey_.Options();
  std::vector<NavPoint> points = options.trajectory.points();
  for (NavPoint& point : points) point.t_s += kWeekS;
  options.trajectory = Trajectory(points);
  EXPECT_EQ(Run(options, "map", "strip.txt").kept, 5u);
}

TEST_F(GeoreferenceStrip, TheCovarianceIsInTheAxesOfThePoints) {
  const PointCrs crs("ecef", survey_.motion.frame);
  const std::vector<double> epochs_s = Epochs(5);
  folder_.Write("strip.las", Las(survey_, crs, epochs_s));
  GeoreferenceOptions options = survey_.Options();
  StripErrors& errors = options.errors.emplace();
  errors.sigma_ned_m = Vector3d(0.02, 0.03, 0.05);
  errors.sigma_rph_rad = Vector3d(3e-5, 4e-5, 9e-5);
  errors.boresight_rad2 = Vector3d(1e-9, 2e-9, 4e-9).asDiagonal();
  errors.sigma_range_m = 0.02;
  errors.sigma_beam_rad = 1e-4;
  Run(options, "ecef", "strip.las");
  const StripCloud points = ReadAll(Out("strip.las"));
  for (std::size_t i = 0; i < epochs_s.size(); ++i) {
    // Computed from differences of the attitude angles, instead of the library's Jacobian.
    const MapPose pose = survey_.motion.Pose(epochs_s[i] - kBegin_s);
    const Vector3d u_s = Survey::Beam(epochs_s[i]);
    const Matrix3d R_mn = survey_.motion.frame.R_mn(pose.p_mb);
    const Eigen::Quaterniond q_nb(R_mn.transpose() * pose.q_mb.toRotationMatrix());
    const Vector3d rph_rad = RollPitchHeading(q_nb);
    PointErrors rest;
    rest.boresight_rad2 = errors.boresight_rad2;
    rest.sigma_range_m = errors.sigma_range_m;
    rest.sigma_beam_rad = errors.sigma_beam_rad;
    Matrix3d C_m = PointCovariance(pose, survey_.mounting, u_s, rest);
    C_m += R_mn * errors.sigma_ned_m.cwiseAbs2().asDiagonal() * R_mn.transpose();
    for (int k = 0; k < 3; ++k) {
      MapPose turned = pose;
      turned.q_mb = Eigen::Quaterniond(
          R_mn *
          QuaternionFromRollPitchHeading(rph_rad + 1e-6 * Vector3d::Unit(k)).toRotationMatrix());
      const Vector3d d_m = (Georeference(turned, survey_.mounting, u_s) -
                            Georeference(pose, survey_.mounting, u_s)) /
                           1e-6;
      C_m += errors.sigma_rph_rad[k] * errors.sigma_rph_rad[k] * d_m * d_m.transpose();
    }
    const Matrix3d R_em = survey_.motion.frame.R_me().transpose();
    const Matrix3d C_e = R_em * C_m * R_em.transpose();
    float stored[6];
    std::memcpy(stored, points.records.data() + i * points.record_bytes + 30, sizeof stored);
    const double expected[6] = {C_e(0, 0), C_e(1, 1), C_e(2, 2), C_e(0, 1), C_e(0, 2), C_e(1, 2)};
    for (int k = 0; k < 6; ++k) EXPECT_NEAR(stored[k], expected[k], 1e-4 * C_e.norm()) << k;
  }
}

TEST_F(GeoreferenceStrip, FilesThatCannotBeUsedAreNamed) {
  const GeoreferenceOptions options = survey_.Options();
  LasBytes timeless;
  timeless.format = 0;
  timeless.points.resize(1);
  folder_.Write("timeless.las", timeless.Build());
  folder_.Write("empty.las", LasBytes().Build());
  folder_.Write("late.txt", "481000, 1, 2, 3, 4, 5, 6\n");
  folder_.Write("far.txt", "381001, 4e5, 5e6, 300, 4, 5, 6\n");
  const auto run = [&](const char* name) { return [&, name] { Run(options, "map", name); }; };
  ExpectInvalidIn(run("timeless.las"), "no GPS time", "timeless.las");
  ExpectInvalidIn(run("empty.las"), "the strip has no points", "empty.las");
  ExpectInvalidIn(run("late.txt"), "all lie after the trajectory", "late.txt");
  ExpectInvalidIn(run("far.txt"),
                  "point 1: the point (4e+05, 5e+06, 300) m is not a valid point in the",
                  "far.txt");
  for (const auto& entry : fs::directory_iterator(folder_.path())) {
    EXPECT_THAT(entry.path().filename().string(), ::testing::Not(::testing::HasSubstr("new_")));
  }
}

TEST_F(GeoreferenceStrip, AnEndLeavesNoFile) {
  folder_.Write("strip.txt", Text(Epochs(5)));
  const StripGeoreferencer georeferencer(survey_.Options(), survey_.motion.frame,
                                         PointCrs("map", survey_.motion.frame));
  const auto stop = [](std::uint64_t) { throw std::runtime_error("stop"); };
  EXPECT_THROW(georeferencer.Run(folder_.path() / "strip.txt", Out("strip.txt"), stop),
               std::runtime_error);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator()), 1);
}

/// The output of a StripSource for a file.
struct SourcedStrip {
  LaserVectors vectors;
  StripCounts counts;
};

SourcedStrip ReadBySource(const Survey& survey, const fs::path& file, const std::string& crs) {
  StripSourceOptions options;
  options.trajectory = survey.Flown();
  options.made_with.mounting = survey.mounting;
  const StripSource source(options, survey.motion.frame, crs);
  SourcedStrip strip;
  strip.counts = source.Read(file, [&](const LaserVectors& chunk) {
    strip.vectors.t_s.insert(strip.vectors.t_s.end(), chunk.t_s.begin(), chunk.t_s.end());
    strip.vectors.u_s.insert(strip.vectors.u_s.end(), chunk.u_s.begin(), chunk.u_s.end());
  });
  return strip;
}

TEST_F(GeoreferenceStrip, ASourceFindsTheVectorsThatLedToPoints) {
  const std::vector<double> epochs_s = Epochs(40);
  folder_.Write("strip.las", Las(survey_, PointCrs("utm:32n", survey_.motion.frame), epochs_s));
  const SourcedStrip strip = ReadBySource(survey_, folder_.path() / "strip.las", "utm:32n");
  EXPECT_EQ(strip.counts.origin->kind, VectorOrigin::Kind::kAssumed);
  ASSERT_EQ(strip.vectors.size(), epochs_s.size());
  for (std::size_t i = 0; i < epochs_s.size(); ++i) {
    EXPECT_NEAR((strip.vectors.u_s[i] - Survey::Beam(epochs_s[i])).norm(), 0.0, kGridM);
  }
}

TEST_F(GeoreferenceStrip, ASourceTakesTheVectorsOfTheFileAndLeavesOutWhatHasNoPose) {
  const std::vector<double> epochs_s = Epochs(60);  // the last ones lie after the trajectory
  folder_.Write("strip.txt", Text(epochs_s));
  const SourcedStrip strip = ReadBySource(survey_, folder_.path() / "strip.txt", "map");
  EXPECT_EQ(strip.counts.origin->kind, VectorOrigin::Kind::kMeasured);
  EXPECT_EQ(strip.counts.points, 60u);
  ASSERT_LT(strip.vectors.size(), 60u);
  EXPECT_EQ(strip.counts.dropped.at("after the trajectory"), 60u - strip.vectors.size());
  for (std::size_t i = 0; i < strip.vectors.size(); ++i) {
    EXPECT_EQ(strip.vectors.u_s[i], Survey::Beam(epochs_s[i]));
  }
}

TEST_F(GeoreferenceStrip, ADeclaredBoresightWinsOverTheInitialOne) {
  const std::vector<double> epochs_s = Epochs(20);
  folder_.Write("strip.las", Las(survey_, PointCrs("map", survey_.motion.frame), epochs_s));
  StripSourceOptions options;
  options.trajectory = survey_.Flown();
  options.made_with = {survey_.mounting, survey_.mounting.boresight_rad};
  options.made_with.mounting.boresight_rad = Vector3d::Zero();
  const StripSource source(options, survey_.motion.frame, "map");
  LaserVectors vectors;
  const StripCounts counts = source.Read(folder_.path() / "strip.las",
                                         [&](const LaserVectors& chunk) { vectors = chunk; });
  EXPECT_EQ(counts.origin->kind, VectorOrigin::Kind::kDeclared);
  EXPECT_EQ(counts.origin->boresight_rad, survey_.mounting.boresight_rad);
  for (std::size_t i = 0; i < epochs_s.size(); ++i) {
    EXPECT_NEAR((vectors.u_s[i] - Survey::Beam(epochs_s[i])).norm(), 0.0, kGridM);
  }
}

TEST_F(GeoreferenceStrip, ANewFileRecordsTheBoresightOfItsPoints) {
  const std::vector<double> epochs_s = Epochs(20);
  folder_.Write("strip.las", Las(survey_, PointCrs("map", survey_.motion.frame), epochs_s));
  GeoreferenceOptions options = survey_.Options();
  options.made_with.declared_rad = survey_.mounting.boresight_rad;
  options.mounting.boresight_rad = Vector3d(-0.1, 0.2, 0.5) * kRadPerDeg;
  Run(options, "map", "strip.las");
  // From now on the boresight in flight.yaml has no influence.
  const SourcedStrip strip = ReadBySource(survey_, Out("strip.las"), "map");
  EXPECT_EQ(strip.counts.origin->kind, VectorOrigin::Kind::kRecorded);
  EXPECT_LT((strip.counts.origin->boresight_rad - options.mounting.boresight_rad).norm(), 1e-15);
  for (std::size_t i = 0; i < epochs_s.size(); ++i) {
    EXPECT_NEAR((strip.vectors.u_s[i] - Survey::Beam(epochs_s[i])).norm(), 0.0, 3.0 * kGridM);
  }
}

TEST_F(GeoreferenceStrip, PointsOfAssumedVectorsRecordNothing) {
  folder_.Write("strip.las", Las(survey_, PointCrs("map", survey_.motion.frame), Epochs(20)));
  GeoreferenceOptions options = survey_.Options();
  options.made_with.mounting.boresight_rad = Vector3d::Zero();
  EXPECT_EQ(Run(options, "map", "strip.las").origin.kind, VectorOrigin::Kind::kAssumed);
  EXPECT_FALSE(OpenStrip(Out("strip.las"))->boresight_rad());
}

TEST_F(GeoreferenceStrip, ARecordAndADeclarationMustAgree) {
  folder_.Write("strip.las", Las(survey_, PointCrs("map", survey_.motion.frame), Epochs(20)));
  GeoreferenceOptions options = survey_.Options();
  options.made_with.declared_rad = survey_.mounting.boresight_rad;
  Run(options, "map", "strip.las");
  const auto strip = OpenStrip(Out("strip.las"));
  EXPECT_EQ(FindVectorOrigin(*strip, options.made_with, Out("strip.las")).kind,
            VectorOrigin::Kind::kRecorded);
  options.made_with.declared_rad = Vector3d(0.2, 0.03, 0.36) * kRadPerDeg;
  ExpectInvalidIn([&] { FindVectorOrigin(*strip, options.made_with, Out("strip.las")); },
                  "remove the key from flight.yaml", "new_strip.las");
}

TEST_F(GeoreferenceStrip, ASourceNamesBothSpansWhereNothingIsLeft) {
  folder_.Write("strip.txt", Text(Epochs(5, kEnd_s + 100.0)));
  const auto read = [&] { ReadBySource(survey_, folder_.path() / "strip.txt", "map"); };
  ExpectInvalidIn(read, "all lie after the trajectory: the strip covers", "strip.txt");
}

}  // namespace dn::files_test
