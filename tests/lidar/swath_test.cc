#include <dn/lidar/swath.h>
#include <gtest/gtest.h>

#include <cmath>

namespace dn::lidar_test {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kHalfWidth_m = 100.0;
constexpr double kSpeed_mps = 50.0;

double Area(const std::vector<Vector2d>& corners) {
  double twice_m2 = 0.0;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Vector2d& a = corners[k];
    const Vector2d& b = corners[(k + 1) % corners.size()];
    twice_m2 += a.x() * b.y() - a.y() * b.x();
  }
  return std::abs(twice_m2) / 2.0;
}

/// Returns the outline of points across a straight strip, scanned at 20 lines a second.
SwathOutline StraightStrip(double course_rad, double duration_s) {
  SwathOutline outline;
  const Vector2d ahead(std::sin(course_rad), std::cos(course_rad));
  const Vector2d right(ahead.y(), -ahead.x());
  for (int line = 0; line < static_cast<int>(duration_s * 20.0); ++line) {
    const double t_s = 1000.0 + line / 20.0;
    for (int k = -10; k <= 10; ++k) {
      const Vector2d p_en_m = ahead * kSpeed_mps * (t_s - 1000.0) + right * kHalfWidth_m * k / 10.0;
      outline.Add(t_s, Vector3d(p_en_m.x(), p_en_m.y(), 12.0));
    }
  }
  return outline;
}

class SwathCourse : public ::testing::TestWithParam<double> {};

TEST_P(SwathCourse, ItsOutlineIsAsWideAsTheStrip) {
  constexpr double kDuration_s = 200.0;
  const std::vector<Vector2d> corners = StraightStrip(GetParam(), kDuration_s).Corners();
  EXPECT_LE(corners.size(), 120u);
  const double area_m2 = 2.0 * kHalfWidth_m * kSpeed_mps * kDuration_s;
  EXPECT_NEAR(Area(corners) / area_m2, 1.0,
              0.03);  // each end of the strip loses half a stretch of time
}

INSTANTIATE_TEST_SUITE_P(Courses, SwathCourse, ::testing::Values(0.0, 0.3, 1.0, 2.0, 3.14, 5.0));

TEST(SwathOutline, SurroundsThePointsOfOneSecond) {
  const std::vector<Vector2d> corners = StraightStrip(0.0, 0.9).Corners();
  EXPECT_NEAR(Area(corners), 2.0 * kHalfWidth_m * kSpeed_mps * 0.85, 1.0);
}

TEST(SwathOutline, IsEmptyForFewerThanThreePoints) {
  EXPECT_TRUE(SwathOutline().Corners().empty());
  SwathOutline one;
  one.Add(1.0, Vector3d(1.0, 2.0, 3.0));
  EXPECT_TRUE(one.Corners().empty());
}

TEST(EvenTimes, IncludeBothEnds) {
  EXPECT_EQ(EvenTimes(1.0, 3.0, 3), (std::vector<double>{1.0, 2.0, 3.0}));
}

}  // namespace dn::lidar_test
