#pragma once

#include <dn/sim/scenario.h>
#include <dn/sim/uniform_spline.h>

#include <Eigen/Core>
#include <vector>

namespace dn {

/// Path to fly, and the times of its strips.
struct FlightPlan {
  UniformSpline path;  ///< its times count from the start of the flight
  double duration_s = 0.0;
  double mean_speed_mps = 0.0;            ///< mean over the lines
  std::vector<Eigen::Vector2d> strips_s;  ///< begin and end of each strip, as times of the path
};

/// Connects warm-up legs, the planned lines and a run-out by coordinated turns of at most bank_rad.
/// The first strip begins warm_up_s after the start.
FlightPlan PlanFlight(const PlanScenario& plan);

}  // namespace dn
