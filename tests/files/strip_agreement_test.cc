#include <dn/files/strip_agreement.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace dn::files_test {

using Eigen::Vector3d;
using ::testing::HasSubstr;
using Kind = StripDisagreement::Kind;

constexpr double kSpeedMps = 30.0, kHeightM = 200.0, kEndS = 195.0;
constexpr double kDegree = 0.017453292519943295;

/// Returns the pose on a racetrack with turns of 60 s, shaken in roll and pitch.
std::optional<MapPose> OnRacetrack(double t_s) {
  if (t_s < 0.0 || t_s > kEndS) return std::nullopt;
  const double lap_s = std::fmod(t_s, 200.0);
  const double radius_m = kSpeedMps * 60.0 / M_PI, line_m = 40.0 * kSpeedMps;
  MapPose pose;
  pose.t_s = t_s;
  double course = 0.0;  // from east, counterclockwise
  if (lap_s < 40.0) {
    pose.p_mb = Vector3d(kSpeedMps * lap_s, 0.0, kHeightM);
  } else if (lap_s < 100.0) {
    course = (lap_s - 40.0) / 60.0 * M_PI;
    pose.p_mb = Vector3d(line_m + radius_m * std::sin(course), radius_m * (1.0 - std::cos(course)),
                         kHeightM);
  } else if (lap_s < 140.0) {
    course = M_PI;
    pose.p_mb = Vector3d(line_m - kSpeedMps * (lap_s - 100.0), 2.0 * radius_m, kHeightM);
  } else {
    course = M_PI + (lap_s - 140.0) / 60.0 * M_PI;
    pose.p_mb =
        Vector3d(radius_m * std::sin(course), radius_m * (1.0 - std::cos(course)), kHeightM);
  }
  pose.p_mb.z() += 3.0 * std::sin(0.7 * t_s);
  pose.v_m = kSpeedMps * Vector3d(std::cos(course), std::sin(course), 0.0);
  Eigen::Matrix3d R;
  R << Vector3d(std::cos(course), std::sin(course), 0.0),
      Vector3d(std::sin(course), -std::cos(course), 0.0), -Vector3d::UnitZ();
  pose.q_mb =
      Eigen::Quaterniond(R) *
      Eigen::Quaterniond(
          Eigen::AngleAxisd(2.0 * kDegree * std::sin(1.9 * t_s), Vector3d::UnitY())) *
      Eigen::Quaterniond(Eigen::AngleAxisd(2.0 * kDegree * std::sin(1.3 * t_s), Vector3d::UnitX()));
  return pose;
}

/// Returns points of a line scanner on hilly ground between 5 and 35 s.
std::vector<StripSample> Strip(const Vector3d& boresight_rad, bool vectors,
                               const std::function<void(StripSample*)>& change) {
  Mounting mounting;
  mounting.boresight_rad = boresight_rad;
  std::vector<StripSample> samples;
  for (int k = 0; k < 600; ++k) {
    StripSample sample;
    sample.t_s = 5.0 + 0.05 * k;
    const MapPose pose = *OnRacetrack(sample.t_s);
    const double angle = 35.0 * kDegree * std::sin(2.1 * k);
    const Vector3d beam(0.0, std::sin(angle), std::cos(angle));
    const Vector3d far_m = Georeference(pose, mounting, beam);
    const double ground_m = 12.0 * std::sin(0.31 * k);
    const Vector3d u_s = (pose.p_mb.z() - ground_m) / (pose.p_mb.z() - far_m.z()) * beam;
    sample.p_m = Georeference(pose, mounting, u_s);
    if (vectors) sample.u_s = u_s;
    change(&sample);
    samples.push_back(sample);
  }
  return samples;
}

std::optional<StripDisagreement> Find(bool vectors, const std::function<void(StripSample*)>& change,
                                      const Vector3d& boresight_rad = Vector3d::Zero()) {
  return FindStripDisagreement(Strip(boresight_rad, vectors, change), OnRacetrack, 0.0, kEndS,
                               Mounting{}, LargestTurn(Vector3d::Zero(), boresight_rad));
}

TEST(StripAgreement, RightPointsAndBoresightsAgree) {
  const auto keep = [](StripSample*) {};
  for (const bool vectors : {true, false}) {
    EXPECT_FALSE(Find(vectors, keep));
    EXPECT_FALSE(Find(vectors, keep, kDegree * Vector3d(0.2, 0.03, 0.35)));
    EXPECT_FALSE(Find(vectors, keep, kDegree * Vector3d(2, -3, 4)));
  }
}

TEST(StripAgreement, OffsetsOfTheClockAreFound) {
  for (const bool vectors : {true, false}) {
    for (const double offset_s : {-18.0, 18.0, -17.0, 37.0, -2.0, 86400.0, -6.0 * 86400.0}) {
      SCOPED_TRACE(offset_s);
      const auto found = Find(vectors, [&](StripSample* sample) { sample->t_s += offset_s; });
      ASSERT_TRUE(found);
      EXPECT_EQ(found->kind, Kind::kClock);
      EXPECT_NEAR(found->offset_s, offset_s, 0.5);
    }
  }
}

TEST(StripAgreement, AShortOffsetIsFoundWithVectors) {
  const auto found = Find(true, [](StripSample* sample) { sample->t_s -= 0.5; });
  ASSERT_TRUE(found);
  EXPECT_EQ(found->kind, Kind::kClock);
  EXPECT_NEAR(found->apart_m.x(), 15.0, 2.0);
  EXPECT_FALSE(found->Forbids());
  EXPECT_THAT(StripDisagreementText(*found, 0.0), HasSubstr("0.5 s early"));
}

TEST(StripAgreement, ShiftsThatNoBoresightExplainsAreFound) {
  for (const Vector3d& shift_m :
       {Vector3d(0, 0, 50), Vector3d(0, 0, -10), Vector3d(0, 40, 0), Vector3d(0, -12, 8)}) {
    const auto found = Find(true, [&](StripSample* sample) { sample->p_m += shift_m; });
    ASSERT_TRUE(found);
    EXPECT_EQ(found->kind, Kind::kShift);
    EXPECT_NEAR(found->apart_m.z(), shift_m.z(), 0.5);
    EXPECT_NEAR(found->apart_m.y(), -shift_m.y(), 0.5);  // the course is east
  }
}

TEST(StripAgreement, HeightsInFeetAreFound) {
  const auto feet = [](StripSample* sample) { sample->p_m.z() /= 0.3048; };
  const auto found = Find(true, feet);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->kind, Kind::kFeet);
  EXPECT_TRUE(found->Forbids());
}

TEST(StripAgreement, PointsAboveTheTrajectoryAreFound) {
  for (const bool vectors : {true, false}) {
    const auto found = Find(vectors, [](StripSample* sample) { sample->p_m.z() += 900.0; });
    ASSERT_TRUE(found);
    EXPECT_EQ(found->kind, Kind::kAbove);
    EXPECT_TRUE(found->Forbids());
  }
}

TEST(StripAgreement, TagsOfAnotherEpochAreFound) {
  const auto found = Find(false, [](StripSample* sample) {
    sample->t_s -= 1e9;
    sample->p_m += Vector3d(1e5, 2e5, 0);
  });
  ASSERT_TRUE(found);
  EXPECT_EQ(found->kind, Kind::kOutside);
  EXPECT_THAT(StripDisagreementText(*found, 0.0), HasSubstr("0.0 s .. 195.0 s"));
}

TEST(StripAgreement, SamplesAreSpreadOverAllPoints) {
  StripSampler sampler;
  for (int k = 0; k < 100000; ++k) {
    if (sampler.Wants()) sampler.Add({static_cast<double>(k), Vector3d::Zero(), {}});
  }
  EXPECT_LE(sampler.samples().size(), 2000u);
  EXPECT_GE(sampler.samples().size(), 900u);
  EXPECT_GT(sampler.samples().back().t_s, 99000.0);
}

}  // namespace dn::files_test
