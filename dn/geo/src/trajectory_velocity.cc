#include <algorithm>
#include <cmath>

#include "trajectory_io.h"

namespace dn::geo_internal {
namespace {

constexpr double kWindowS = 1.0;
constexpr double kQuantile = 0.95;

struct MapTrack {
  std::vector<Eigen::Vector3d> p_m;
  std::vector<Eigen::Matrix3d> R_mn;
};

MapTrack ToMapTrack(const std::vector<NavPoint>& points) {
  const LocalFrame frame(points.front().position);
  MapTrack track;
  track.p_m.reserve(points.size());
  track.R_mn.reserve(points.size());
  for (const NavPoint& point : points) {
    track.p_m.push_back(frame.ToMap(point.position));
    track.R_mn.push_back(frame.R_me() * R_en(point.position));
  }
  return track;
}

/// Returns the slope at x1 of the parabola through three points.
Eigen::Vector3d ParabolaSlope(double x0, const Eigen::Vector3d& y0, double x1,
                              const Eigen::Vector3d& y1, double x2, const Eigen::Vector3d& y2) {
  const Eigen::Vector3d slope_01 = (y1 - y0) / (x1 - x0);
  const Eigen::Vector3d slope_12 = (y2 - y1) / (x2 - x1);
  const Eigen::Vector3d slope_02 = (y2 - y0) / (x2 - x0);
  return slope_01 + slope_12 - slope_02;
}

double Misfit(const std::vector<NavPoint>& points, const MapTrack& track,
              const std::vector<Eigen::Vector3d>& v_ned_mps) {
  std::vector<double> misfits;
  std::size_t window_begin = 0;
  Eigen::Vector3d integral_m = Eigen::Vector3d::Zero();
  for (std::size_t i = 1; i < points.size(); ++i) {
    integral_m += 0.5 * (points[i].t_s - points[i - 1].t_s) *
                  (track.R_mn[i - 1] * v_ned_mps[i - 1] + track.R_mn[i] * v_ned_mps[i]);
    const double duration_s = points[i].t_s - points[window_begin].t_s;
    const bool last = i + 1 == points.size();
    if (duration_s < kWindowS && !(last && misfits.empty())) continue;
    const Eigen::Vector3d moved_m = track.p_m[i] - track.p_m[window_begin];
    misfits.push_back((moved_m - integral_m).norm() / duration_s);
    window_begin = i;
    integral_m.setZero();
  }
  const auto rank =
      static_cast<std::ptrdiff_t>(std::ceil(kQuantile * static_cast<double>(misfits.size())) - 1.0);
  std::nth_element(misfits.begin(), misfits.begin() + rank, misfits.end());
  return misfits[static_cast<std::size_t>(rank)];
}

}  // namespace

std::vector<Eigen::Vector3d> DifferentiatePositions(const std::vector<NavPoint>& points) {
  const MapTrack track = ToMapTrack(points);
  const std::size_t n = points.size();
  std::vector<Eigen::Vector3d> v_ned(n);
  for (std::size_t i = 0; i < n; ++i) {
    Eigen::Vector3d v_m;
    if (n == 2) {
      v_m = (track.p_m[1] - track.p_m[0]) / (points[1].t_s - points[0].t_s);
    } else {
      // At the ends both neighbours lie on the same side; the formula accepts them in any order.
      const std::size_t a = i == 0 ? 2 : i - 1;
      const std::size_t b = i == n - 1 ? n - 3 : i + 1;
      v_m = ParabolaSlope(points[a].t_s, track.p_m[a], points[i].t_s, track.p_m[i], points[b].t_s,
                          track.p_m[b]);
    }
    v_ned[i] = track.R_mn[i].transpose() * v_m;
  }
  return v_ned;
}

std::vector<double> VelocityMisfits(const std::vector<NavPoint>& points,
                                    const std::vector<std::vector<Eigen::Vector3d>>& v_ned_mps) {
  const MapTrack track = ToMapTrack(points);
  std::vector<double> misfits_mps;
  for (const auto& list : v_ned_mps) misfits_mps.push_back(Misfit(points, track, list));
  return misfits_mps;
}

}  // namespace dn::geo_internal
