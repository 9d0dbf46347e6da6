#pragma once

#include <dn/geo/trajectory.h>

#include "flight_plan.h"

namespace dn {

/// Returns a plan that follows a given trajectory, smoothed over some quarters of a second. Its
/// times count from the first epoch of the trajectory plus kReplayMargin_s. The strips are its
/// straight parts of at least 10 s. Throws InvalidInput if the trajectory is shorter than 10 s or
/// has a gap of more than 1 s.
FlightPlan ReplayFlight(const Trajectory& trajectory, const LocalFrame& frame);

/// Time removed at both ends of a replayed trajectory, s.
inline constexpr double kReplayMargin_s = 1.0;

}  // namespace dn
