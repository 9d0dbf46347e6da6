#pragma once

#include <dn/fixed_trajectory/plane_adjustment.h>

#include <Eigen/Core>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "testing/strip_pairs.h"

namespace dn::testing {

/// Planes on the ground below the lines of a synthetic strip flight.
struct StripPlaneOptions {
  StripPairOptions flight;
  int count = 60;
  int points = 30;             ///< per plane and strip
  double half_extent_m = 4.0;  ///< of a plane
  double steepest_rad = 0.7;   ///< slopes are uniform below this value
  bool one_aspect = false;     ///< all planes slope down to the east
  double sigma_m = 0.02;
};

inline Eigen::Vector3d SlopingNormal(double slope_rad, double aspect_rad) {
  return {std::sin(slope_rad) * std::cos(aspect_rad), std::sin(slope_rad) * std::sin(aspect_rad),
          std::cos(slope_rad)};
}

/// Returns the point of the plane through c with normal n at (a, b) east and north of c.
inline Eigen::Vector3d OnPlane(const Eigen::Vector3d& c, const Eigen::Vector3d& n, double a,
                               double b) {
  return c + Eigen::Vector3d(a, b, -(n.x() * a + n.y() * b) / n.z());
}

/// Returns error-free points on planes that at least two lines observe; the initial boresight is
/// zero. The strips have different points.
inline PlaneProblem MakeStripPlanes(const StripPlaneOptions& options = {}) {
  std::mt19937 rng(options.flight.seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  PlaneProblem problem;
  problem.lever_arm_b_m = options.flight.lever_arm_b_m;
  const auto& lines = options.flight.lines;
  while (static_cast<int>(problem.planes.size()) < options.count) {
    const Eigen::Vector3d c(800.0 * uniform(rng), 800.0 * uniform(rng),
                            0.5 * options.flight.relief_m * uniform(rng));
    const double aspect = options.one_aspect ? 0.0 : 3.14159265358979 * uniform(rng);
    const Eigen::Vector3d n = SlopingNormal(options.steepest_rad * std::abs(uniform(rng)), aspect);
    ObservedPlane plane;
    plane.sigma_m = options.sigma_m;
    int strips = 0;
    for (std::size_t s = 0; s < lines.size(); ++s) {
      const double margin_m = 2.0 * options.half_extent_m;
      if (!Sees(lines[s], c, options.flight.half_width_m - margin_m)) continue;
      ++strips;
      for (int k = 0; k < options.points; ++k) {
        const Eigen::Vector3d x = OnPlane(c, n, options.half_extent_m * uniform(rng),
                                          options.half_extent_m * uniform(rng));
        plane.points.push_back({SeePoint(lines[s], x, options.flight), static_cast<int>(s)});
      }
    }
    if (strips >= 2) problem.planes.push_back(std::move(plane));
  }
  return problem;
}

/// Adds errors to the points: the trajectory error at each epoch, and white noise with the planes'
/// sigma on every point.
inline void Disturb(PlaneProblem* problem,
                    const std::function<PoseError(const GaussHelmertEnd&)>& trajectory,
                    std::mt19937& rng) {
  for (ObservedPlane& plane : problem->planes) {
    for (PlanePoint& point : plane.points) {
      GaussHelmertEnd& end = point.end;
      end.u_b += NormalVector(rng, Eigen::Vector3d::Constant(plane.sigma_m));
      const PoseError error = trajectory(end);
      end.p_mb += error.position_m;
      end.q_mb = (end.q_mb * Exp(error.attitude_rad)).normalized();
    }
  }
}

}  // namespace dn::testing
