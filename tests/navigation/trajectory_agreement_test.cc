#include <dn/navigation/attitude_agreement.h>
#include <dn/navigation/track_agreement.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "testing/short_flights.h"

namespace dn::navigation_test {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Kind = AttitudeMistake::Kind;

/// Returns a flight whose trajectory is the simulated truth, with every point changed.
Flight Changed(const std::function<void(NavPoint*)>& change, Scenario scenario) {
  scenario.pairs.count = 0;
  Flight flight = Simulate(scenario, {.seed = 3}).flight;
  std::vector<NavPoint> points;
  for (const NavPoint& point : flight.reference->points()) {
    if (!points.empty() && point.t_s - points.back().t_s < 0.1) continue;
    points.push_back(point);
  }
  for (NavPoint& point : points) change(&point);
  flight.trajectory.emplace(points);
  return flight;
}

Flight Changed(const std::function<void(NavPoint*)>& change) {
  return Changed(change, testing::DroneScenario());
}

void Keep(NavPoint*) {}

TEST(TrackAgreement, RightTrajectoriesAgree) {
  for (const Scenario& scenario : {testing::DroneScenario(), testing::AircraftScenario()}) {
    Flight flight = Changed(Keep, scenario);
    EXPECT_TRUE(CompareTracks(flight)->Agrees());
    EXPECT_FALSE(FindAttitudeMistake(flight));
    flight.config.gnss->lever_arm_b_m.setZero();
    EXPECT_TRUE(CompareTracks(flight)->Agrees());
    flight.gnss.reset();
    EXPECT_FALSE(CompareTracks(flight));
  }
}

TEST(TrackAgreement, OffsetsOfTheClockAreFound) {
  for (const double shift_s : {-18.0, 18.0, 0.8, -5.3, 37.0, 3600.0, 86400.0, -3.0 * 86400.0}) {
    SCOPED_TRACE(shift_s);
    const auto found = CompareTracks(Changed([&](NavPoint* point) { point->t_s += shift_s; }));
    ASSERT_TRUE(found && found->one_motion);
    EXPECT_NEAR(found->shift_s, shift_s, 0.05);
    EXPECT_EQ(found->place, PlaceMistake::kNone);
    EXPECT_EQ(found->height, HeightMistake::kNone);
  }
}

TEST(TrackAgreement, ExchangedCoordinatesOfEitherFileAreFound) {
  const auto exchange = [](NavPoint* point) {
    std::swap(point->position.lat_rad, point->position.lon_rad);
  };
  const auto found = CompareTracks(Changed(exchange));
  EXPECT_EQ(found->place, PlaceMistake::kExchanged);
  EXPECT_GT(found->course_exchanged, found->course_as_read + 0.5);
  Flight flight = Changed(Keep);
  for (MapGnssEpoch& epoch : flight.gnss->epochs) {
    Geodetic place = flight.frame.ToGeodetic(epoch.p_m);
    std::swap(place.lat_rad, place.lon_rad);
    epoch.p_m = flight.frame.ToMap(place);
  }
  const auto gnss = CompareTracks(flight);
  EXPECT_EQ(gnss->place, PlaceMistake::kExchanged);
  EXPECT_GT(gnss->course_as_read, gnss->course_exchanged + 0.5);
}

TEST(TrackAgreement, RadiansAndOtherPlacesAreFound) {
  const auto radians = [](NavPoint* point) {
    point->position.lat_rad *= kRadPerDeg;
    point->position.lon_rad *= kRadPerDeg;
  };
  EXPECT_EQ(CompareTracks(Changed(radians))->place, PlaceMistake::kTrajectoryRadians);
  const auto north = [](NavPoint* point) { point->position.lat_rad += 0.5 * kRadPerDeg; };
  const auto found = CompareTracks(Changed(north));
  EXPECT_EQ(found->place, PlaceMistake::kElsewhere);
  EXPECT_NEAR(found->distance_m, 55.6e3, 1e3);
}

TEST(TrackAgreement, HeightsOfOtherKindsAreFound) {
  for (const double up_m : {50.0, -48.0, 8.0}) {
    SCOPED_TRACE(up_m);
    const auto found =
        CompareTracks(Changed([&](NavPoint* point) { point->position.h_m += up_m; }));
    EXPECT_EQ(found->height, HeightMistake::kConstant);
    EXPECT_NEAR(found->apart_enu_m.z(), up_m, 0.5);
  }
  const auto feet = [](NavPoint* point) { point->position.h_m /= 0.3048; };
  EXPECT_EQ(CompareTracks(Changed(feet))->height, HeightMistake::kTrajectoryFeet);
  const auto scaled = [](NavPoint* point) { point->position.h_m *= 0.3048; };
  EXPECT_EQ(CompareTracks(Changed(scaled))->height, HeightMistake::kGnssFeet);
}

TEST(TrackAgreement, AnotherFlightIsNoOffset) {
  Flight flight = Changed(Keep);
  const Flight other = Changed(Keep, testing::AircraftScenario());
  flight.trajectory = other.trajectory;
  EXPECT_FALSE(CompareTracks(flight)->Agrees());
  EXPECT_FALSE(CompareTracks(flight)->one_motion);
}

Vector3d Angles(const Quaterniond& q_nb) {
  const Eigen::Matrix3d R = q_nb.toRotationMatrix();
  return {std::atan2(R(2, 1), R(2, 2)), -std::asin(R(2, 0)), std::atan2(R(1, 0), R(0, 0))};
}

Quaterniond FromAngles(double roll_rad, double pitch_rad, double heading_rad) {
  return Quaterniond(Eigen::AngleAxisd(heading_rad, Vector3d::UnitZ()) *
                     Eigen::AngleAxisd(pitch_rad, Vector3d::UnitY()) *
                     Eigen::AngleAxisd(roll_rad, Vector3d::UnitX()));
}

void ExpectMistake(Kind kind, const std::function<Quaterniond(const Quaterniond&)>& wrong) {
  for (const Scenario& scenario : {testing::DroneScenario(), testing::AircraftScenario()}) {
    SCOPED_TRACE(scenario.name);
    const auto found = FindAttitudeMistake(
        Changed([&](NavPoint* point) { point->q_nb = wrong(point->q_nb); }, scenario));
    ASSERT_TRUE(found);
    EXPECT_EQ(found->kind, kind);
  }
}

TEST(AttitudeAgreement, WrongAnglesAreFound) {
  ExpectMistake(Kind::kRollSign, [](const Quaterniond& q) {
    const Vector3d a = Angles(q);
    return FromAngles(-a.x(), a.y(), a.z());
  });
  ExpectMistake(Kind::kPitchSign, [](const Quaterniond& q) {
    const Vector3d a = Angles(q);
    return FromAngles(a.x(), -a.y(), a.z());
  });
  ExpectMistake(Kind::kHeadingSign, [](const Quaterniond& q) {
    const Vector3d a = Angles(q);
    return FromAngles(a.x(), a.y(), -a.z());
  });
  ExpectMistake(Kind::kRollPitchExchanged, [](const Quaterniond& q) {
    const Vector3d a = Angles(q);
    return FromAngles(a.y(), a.x(), a.z());
  });
  ExpectMistake(Kind::kInverse, [](const Quaterniond& q) { return q.conjugate(); });
}

TEST(AttitudeAgreement, OtherBodyAxesAreFound) {
  for (const int axis : {0, 1, 2}) {
    for (const double turn_deg : {90.0, 180.0}) {
      ExpectMistake(Kind::kAxes, [&](const Quaterniond& q) {
        return q * Quaterniond(Eigen::AngleAxisd(turn_deg * kRadPerDeg, Vector3d::Unit(axis)));
      });
    }
  }
}

TEST(AttitudeAgreement, AnotherClockIsTakenIntoAccount) {
  const Flight flight = Changed([](NavPoint* point) {
    point->t_s -= 18.0;
    point->q_nb = point->q_nb * Quaterniond(0.0, 1.0, 0.0, 0.0);
  });
  EXPECT_TRUE(FindAttitudeMistake(flight, -18.0));
  EXPECT_FALSE(FindAttitudeMistake(flight));
}

// Logs of flight controllers have clocks, sensor axes and resolutions of their own.
TEST(AttitudeAgreement, IndependentClocksAndAxesAreFound) {
  for (const double shift_s : {0.0, -497.13, 3.2, 1e5}) {
    SCOPED_TRACE(shift_s);
    Flight flight = Changed([&](NavPoint* point) {
      point->t_s += shift_s;
      const Vector3d a = (Angles(point->q_nb) * kDegPerRad * 10.0).array().round() / 10.0;
      point->q_nb = FromAngles(a.x() * kRadPerDeg, a.y() * kRadPerDeg, a.z() * kRadPerDeg);
    });
    const Quaterniond q_sb = FromAngles(std::numbers::pi, 0.02, -1.5);
    for (ImuSample& sample : flight.imu->samples) sample.w_ib_b_radps = q_sb * sample.w_ib_b_radps;
    const auto found = CompareAttitudes(flight);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->offset_s, shift_s, 4.0 * found->sigma_offset_s);
    EXPECT_LT(found->q_ba.angularDistance(q_sb.conjugate()), 0.02);
  }
}

TEST(AttitudeAgreement, OtherTurnsAreNotCompared) {
  Flight flight = Changed(Keep);
  const auto shrunk = [](NavPoint* point) {
    const Vector3d a = Angles(point->q_nb);
    point->q_nb = FromAngles(a.x() * kRadPerDeg, a.y() * kRadPerDeg, a.z() * kRadPerDeg);
  };
  EXPECT_TRUE(CompareAttitudes(flight));
  EXPECT_FALSE(CompareAttitudes(Changed(shrunk)));  // degrees that were taken as radians
  Flight other = flight;
  other.trajectory = Changed(Keep, testing::AircraftScenario()).trajectory;
  EXPECT_FALSE(CompareAttitudes(other));
  flight.trajectory.reset();
  EXPECT_FALSE(CompareAttitudes(flight));
}

}  // namespace dn::navigation_test
