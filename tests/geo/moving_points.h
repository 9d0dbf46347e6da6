#pragma once

#include <dn/geo/trajectory.h>
#include <dn/rotation.h>

#include <cmath>
#include <vector>

namespace dn::testing {

/// Returns a climbing turn at 50 m/s that starts at (46.57, 6.52) deg, with n points every dt_s. It
/// has exact velocities, and a heading that differs from the course.
inline std::vector<NavPoint> MovingPoints(int n, double dt_s) {
  const LocalFrame frame({46.57 * kRadPerDeg, 6.52 * kRadPerDeg, 500.0});
  constexpr double kSpeedMps = 50.0, kTurnRadps = 0.05, kClimbMps = 2.0;
  std::vector<NavPoint> points;
  for (int i = 0; i < n; ++i) {
    const double t_s = i * dt_s, course_rad = 0.4 + kTurnRadps * t_s;
    const double radius_m = kSpeedMps / kTurnRadps;
    MapPose pose;
    pose.t_s = 381000.0 + t_s;
    pose.p_mb = {-radius_m * std::cos(course_rad), radius_m * std::sin(course_rad),
                 kClimbMps * t_s};
    pose.v_m = {kSpeedMps * std::sin(course_rad), kSpeedMps * std::cos(course_rad), kClimbMps};
    NavPoint point = ToNavPoint(pose, frame);
    point.q_nb = QuaternionFromRollPitchHeading({0.25, 0.04, course_rad + 0.05});
    point.f_b_mps2 = {0.1, 0.2, -9.9 - 0.01 * i};
    point.w_b_radps = {0.01, 0.02, kTurnRadps};
    points.push_back(point);
  }
  return points;
}

}  // namespace dn::testing
