#pragma once

#include <dn/geo/trajectory.h>

#include "flight_plan.h"

namespace dn {

/// The path of a given trajectory, smoothed over a few quarters of a second; its times count from
/// the trajectory's first epoch plus replay_margin_s. Strips are its straight stretches of at least
/// 10 s. Throws InvalidInput when it is shorter than 10 s or has a hole of more than 1 s.
FlightPlan ReplayFlight(const Trajectory& trajectory, const LocalFrame& frame);

/// Seconds cut off at both ends of a replayed trajectory.
inline constexpr double kReplayMargin_s = 1.0;

}  // namespace dn
