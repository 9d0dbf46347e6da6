#include <dn/files/flight.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace dn::files_test {

LidarPair PairAt(double t_i_s, double t_j_s) {
  LidarPair pair;
  pair.t_i_s = t_i_s;
  pair.t_j_s = t_j_s;
  return pair;
}

TEST(FindStrips, TakesThoseOfTheConfiguration) {
  Flight flight;
  flight.config.strips = {{"a", 1.0, 2.0}};
  flight.pairs = PairData{{}, {PairAt(10, 100)}};
  const std::vector<StripInterval> strips = FindStrips(flight);
  ASSERT_EQ(strips.size(), 1u);
  EXPECT_EQ(strips[0].name, "a");
}

TEST(FindStrips, SeparatesEpochsOfPairsByHolesOfMoreThanFiveSeconds) {
  Flight flight;
  flight.pairs = PairData{{}, {PairAt(14, 103), PairAt(10, 100), PairAt(19, 108.5)}};
  const std::vector<StripInterval> strips = FindStrips(flight);
  ASSERT_EQ(strips.size(), 3u);
  EXPECT_EQ(strips[0].name, "1");
  EXPECT_EQ(strips[0].t0_s, 10.0);
  EXPECT_EQ(strips[0].t1_s, 19.0);
  EXPECT_EQ(strips[1].t1_s, 103.0);
  EXPECT_EQ(strips[2].name, "3");
  EXPECT_EQ(strips[2].t0_s, 108.5);
}

TEST(FindStrips, PrefersTheStripsOfAllPairsToThoseOfASelection) {
  Flight flight;
  flight.pairs = PairData{{}, {PairAt(10, 100)}};
  flight.pair_strips = {{"1", 0.0, 50.0}};
  EXPECT_EQ(FindStrips(flight).size(), 1u);
}

// The flight goes east for 60 s, makes a half turn at 6 deg/s, and goes west for 60 s. Its speed is
// 50 m/s, and the data have 10 Hz.
TEST(FindStrips, FindsTheStraightLegsOfATrajectory) {
  const double deg = std::acos(-1.0) / 180.0;
  std::vector<NavPoint> points;
  for (int i = 0; i <= 1500; ++i) {
    NavPoint point;
    point.t_s = 1000.0 + 0.1 * i;
    const double course = deg * (90.0 + 6.0 * std::clamp(point.t_s - 1060.0, 0.0, 30.0));
    point.v_ned_mps = 50.0 * Eigen::Vector3d(std::cos(course), std::sin(course), 0.0);
    points.push_back(point);
  }
  Flight flight;
  flight.trajectory = Trajectory(points);
  const std::vector<StripInterval> strips = FindStrips(flight);
  constexpr double kWindowS = 6.0;  // the course is compared over 5 s to both sides
  ASSERT_EQ(strips.size(), 2u);
  EXPECT_NEAR(strips[0].t0_s, 1000.0, kWindowS);
  EXPECT_NEAR(strips[0].t1_s, 1060.0, kWindowS);
  EXPECT_NEAR(strips[1].t0_s, 1090.0, kWindowS);
  EXPECT_NEAR(strips[1].t1_s, 1150.0, kWindowS);
}

TEST(FindStrips, FindsNothingInNothing) { EXPECT_TRUE(FindStrips(Flight{}).empty()); }

}  // namespace dn::files_test
