#include <dn/adjustment/pose_interpolator.h>
#include <dn/error.h>
#include <dn/rotation.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace dn::adjustment_test {

constexpr double kAmplitudeRad = 0.02;
constexpr double kMotionHz = 1.0;
constexpr double kW = 2.0 * std::numbers::pi * kMotionHz;

/// A platform that oscillates in roll, on a southern course, where heading wraps.
MapPose TruePose(double t_s) {
  MapPose pose;
  pose.t_s = t_s;
  pose.q_mb = QuaternionFromRollPitchHeading(
      Eigen::Vector3d(kAmplitudeRad * std::sin(kW * t_s), 0.01, std::numbers::pi + 1e-3 * t_s));
  pose.p_mb = Eigen::Vector3d(40.0 * t_s, 0.5 * std::sin(kW * t_s), 100.0);
  pose.v_m = Eigen::Vector3d(40.0, 0.5 * kW * std::cos(kW * t_s), 0.0);
  return pose;
}

std::vector<MapPose> Poses(double rate_hz, double begin_s = 0.0, double end_s = 10.0) {
  std::vector<MapPose> poses;
  for (int k = 0; begin_s + k / rate_hz <= end_s; ++k)
    poses.push_back(TruePose(begin_s + k / rate_hz));
  return poses;
}

double LargestError(const PoseInterpolator& poses, double begin_s, double end_s,
                    PoseInterpolator::Method method = PoseInterpolator::Method::kCubic) {
  double largest = 0.0;
  for (double t_s = begin_s; t_s < end_s; t_s += 0.00717) {
    largest = std::max(largest, poses.At(t_s, method).q_mb.angularDistance(TruePose(t_s).q_mb));
  }
  return largest;
}

class Rates : public ::testing::TestWithParam<double> {};

// The header states the error in the middle of a step.
TEST_P(Rates, ErrorIsWhatTheHeaderSays) {
  const double ratio = kW / GetParam();
  const PoseInterpolator poses(Poses(GetParam()));
  const double expected_cubic = 0.0234 * std::pow(ratio, 4) * kAmplitudeRad;
  const double expected_linear = 0.125 * ratio * ratio * kAmplitudeRad;
  constexpr double kFloor = 5e-8;  // rounding of angularDistance
  EXPECT_LE(LargestError(poses, 0.5, 9.0), 1.05 * expected_cubic + kFloor);
  EXPECT_NEAR(LargestError(poses, 0.5, 9.0, PoseInterpolator::Method::kLinear), expected_linear,
              0.1 * expected_linear);
}

INSTANTIATE_TEST_SUITE_P(PoseInterpolator, Rates, ::testing::Values(10.0, 50.0, 200.0));

TEST(PoseInterpolator, ReturnsTheEpochsThemselves) {
  const std::vector<MapPose> poses = Poses(10.0);
  const PoseInterpolator interpolator(poses);
  for (const MapPose& pose : poses) {
    const MapPose at = interpolator.At(pose.t_s);
    EXPECT_LE((at.p_mb - pose.p_mb).norm(), 1e-12);
    EXPECT_LE(at.q_mb.angularDistance(pose.q_mb), 1e-7);
  }
}

TEST(PoseInterpolator, EndsAndGapsLowerTheDegreeOnly) {
  std::vector<MapPose> poses = Poses(50.0, 0.0, 2.0);
  const std::vector<MapPose> later = Poses(50.0, 5.0, 7.0);
  poses.insert(poses.end(), later.begin(), later.end());
  const PoseInterpolator interpolator(poses);
  const double ratio = kW / 50.0;
  const double quadratic =
      0.0642 * std::pow(ratio, 3) * kAmplitudeRad + 5e-8;  // h^3 f''' / 9 sqrt(3)
  EXPECT_LE(LargestError(interpolator, 0.0, 0.02), quadratic);
  EXPECT_LE(LargestError(interpolator, 1.98, 1.999), quadratic);
  EXPECT_LE(LargestError(interpolator, 5.0, 5.02), quadratic);
}

TEST(PoseInterpolator, TheSignOfAQuaternionIsFree) {
  std::vector<MapPose> poses = Poses(50.0);
  for (std::size_t k = 0; k < poses.size(); k += 3) poses[k].q_mb.coeffs() *= -1.0;
  const PoseInterpolator interpolator(poses);
  EXPECT_LE(LargestError(interpolator, 0.5, 9.0), 1e-6);
}

TEST(PoseInterpolator, OutsideIsAnErrorThatNamesTheTimes) {
  const PoseInterpolator interpolator(Poses(10.0));
  try {
    interpolator.At(10.5);
    FAIL();
  } catch (const InvalidInput& e) {
    EXPECT_THAT(e.what(), ::testing::HasSubstr("10.5"));
    EXPECT_THAT(e.what(), ::testing::HasSubstr("0 s to 10 s"));
  }
  EXPECT_THROW(PoseInterpolator({TruePose(0.0)}), InvalidInput);
}

}  // namespace dn::adjustment_test
