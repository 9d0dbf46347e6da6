#include <dn/files/pair_clock.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "testing/expect_invalid.h"

namespace dn::files_test {

using Eigen::Vector3d;

constexpr double kSpeedMps = 30.0, kHeightM = 200.0, kLengthM = 900.0;

/// Returns the pose on two opposite lines over the same ground, with a turn of 60 s between them.
MapPose PoseAt(double t_s, double back_y_m = 0.0) {
  const bool back = t_s > 75.0;
  const double along_m = kSpeedMps * (back ? t_s - 105.0 : t_s - 15.0);
  MapPose pose;
  pose.t_s = t_s;
  pose.p_mb = Vector3d(back ? kLengthM - along_m : along_m, back ? back_y_m : 0.0, kHeightM);
  const Vector3d forward(back ? -1.0 : 1.0, 0.0, 0.0), down(0.0, 0.0, -1.0);
  Eigen::Matrix3d R;
  R << forward, down.cross(forward), down;
  pose.q_mb = Eigen::Quaterniond(R);
  pose.v_m = kSpeedMps * forward;
  return pose;
}

/// Returns a flight whose pairs were measured with this boresight and have tags = t + offset.
Flight TwoLines(double offset_s, const Vector3d& boresight_rad, bool with_trajectory,
                double back_y_m = 0.0) {
  Flight flight;
  flight.frame = LocalFrame({0.81, 0.11, 400.0});
  flight.config.lidar.emplace();
  Mounting mounting;
  mounting.boresight_rad = boresight_rad;
  flight.pairs.emplace();
  flight.pairs->files = {"pairs.txt"};
  for (int k = 0; k < 200; ++k) {
    const Vector3d ground(4.5 * k, 80.0 * std::sin(k), 0.0);
    LidarPair pair;
    const double t_i = 15.0 + ground.x() / kSpeedMps;
    const double t_j = 105.0 + (kLengthM - ground.x()) / kSpeedMps;
    pair.u_i_s = LaserVectorTo(PoseAt(t_i, back_y_m), mounting, ground);
    pair.u_j_s = LaserVectorTo(PoseAt(t_j, back_y_m), mounting, ground);
    pair.t_i_s = t_i + offset_s;
    pair.t_j_s = t_j + offset_s;
    flight.pairs->pairs.push_back(pair);
  }
  std::vector<NavPoint> points;
  flight.gnss.emplace();
  for (double t_s = -40.0; t_s <= 200.0; t_s += 0.5) {
    points.push_back(ToNavPoint(PoseAt(t_s, back_y_m), flight.frame));
    MapGnssEpoch epoch;
    epoch.t_s = t_s;
    epoch.p_m = PoseAt(t_s, back_y_m).p_mb;
    flight.gnss->epochs.push_back(epoch);
  }
  if (with_trajectory) flight.trajectory.emplace(points);
  return flight;
}

TEST(PairClock, FindsTheOffset) {
  for (const bool with_trajectory : {true, false}) {
    for (const double offset_s : {-18.0, -17.0, 18.0, 5.0, -2.5}) {
      const auto found = FindPairClockOffset(TwoLines(offset_s, Vector3d::Zero(), with_trajectory));
      ASSERT_TRUE(found) << offset_s;
      EXPECT_EQ(*found, offset_s);
    }
  }
}

TEST(PairClock, AMountingIsNoClock) {
  constexpr double kDegree = kRadPerDeg;
  for (const Vector3d& boresight_deg : {Vector3d(0, 0, 0), Vector3d(2, -1, 3), Vector3d(5, 5, 5),
                                        Vector3d(0, 8, 0), Vector3d(0, 0, 90)}) {
    for (const bool with_trajectory : {true, false}) {
      EXPECT_FALSE(FindPairClockOffset(TwoLines(0.0, kDegree * boresight_deg, with_trajectory)));
    }
  }
  EXPECT_TRUE(FindPairClockOffset(TwoLines(-18.0, kDegree * Vector3d(2, -1, 3), true)));
}

TEST(PairClock, IsNamedWithTheRemedy) {
  Flight flight = TwoLines(-18.0, Vector3d::Zero(), true);
  testing::ExpectInvalidIn([&] { ExpectPairClock(flight); },
                           "18 s early: are they in UTC? Set lidar.time_offset_s: -18",
                           "pairs.txt");
  flight.pairs->pairs.resize(10);
  ExpectPairClock(flight);
  EXPECT_EQ(LidarClockHint(-17.2, 0.0),
            "17 s early: are they in UTC? Set lidar.time_offset_s: -17");
  EXPECT_EQ(LidarClockHint(3.54, 1.0), "3.5 s late; set lidar.time_offset_s: 4.5");
}

TEST(PairClock, LongOffsetsAreFound) {
  for (const double offset_s : {-37.0, 33.0}) {
    const auto found = FindPairClockOffset(TwoLines(offset_s, Vector3d::Zero(), true));
    ASSERT_TRUE(found);
    EXPECT_NEAR(*found, offset_s, 0.5);
  }
}

// Two opposite lines do not show which of the two tags is wrong.
TEST(PairMistakes, OneOfTheTwoTagsIsFound) {
  for (const bool with_trajectory : {true, false}) {
    for (const double offset_s : {-18.0, 12.0}) {
      Flight first = TwoLines(0.0, Vector3d::Zero(), with_trajectory), second = first;
      for (LidarPair& pair : first.pairs->pairs) pair.t_i_s += offset_s;
      for (LidarPair& pair : second.pairs->pairs) pair.t_j_s += offset_s;
      for (const Flight& flight : {first, second}) {
        EXPECT_EQ(FindPairMistake(flight).kind, PairMistake::Kind::kOneTag);
        EXPECT_NEAR(FindPairMistake(flight).value, offset_s, 0.5);
      }
    }
  }
}

TEST(PairMistakes, VectorsInFeetAreFound) {
  for (const bool with_trajectory : {true, false}) {
    Flight flight = TwoLines(0.0, Vector3d::Zero(), with_trajectory, 120.0);
    EXPECT_EQ(FindPairMistake(flight).kind, PairMistake::Kind::kNone);
    for (LidarPair& pair : flight.pairs->pairs) {
      pair.u_i_s /= 0.3048;
      pair.u_j_s /= 0.3048;
    }
    const PairMistake found = FindPairMistake(flight);
    EXPECT_EQ(found.kind, PairMistake::Kind::kScale);
    EXPECT_NEAR(found.value, 0.3048, 1e-9);
  }
}

TEST(PairClock, WithATrajectoryBothClocksAreNamed) {
  const std::string text = PairClockText(TwoLines(-18.0, Vector3d::Zero(), true), -18.0);
  EXPECT_THAT(text, ::testing::HasSubstr("lidar.time_offset_s: -18"));
  EXPECT_THAT(text, ::testing::HasSubstr("subtract 18 s from its times"));
}

TEST(PairClock, LeapSecondsNeedAFittingOffset) {
  EXPECT_EQ(LidarClockHint(-17.2, 0.0, 0.1), "17.2 s early; set lidar.time_offset_s: -17.2");
  EXPECT_EQ(LidarClockHint(86400.1, 0.0),
            "86400 s late: do they count from another day or week? Set lidar.time_offset_s: 86400");
}

}  // namespace dn::files_test
