#pragma once

#include <dn/flight/flight.h>
#include <dn/gap/diagnosis.h>
#include <dn/geo/trajectory.h>
#include <dn/sim/scenario.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace dn {

/// The trajectory that TwinScenario replays; it lies beside the scenario.
inline constexpr const char* kTwinTrajectoryFile = "trajectory.out";

/// A scenario that flies a flight again, with these effects in its data: the estimated trajectory
/// and boresight as the truth, the strips, the rates and the assumed noise of its sensors, its
/// mounting, lever arms, number and noise of pairs. What the flight does not state is taken from its
/// pairs: the field of view and pattern of the scan, and height and roughness of the ground.
///
/// `flight` has IMU and GNSS data. Holes of its data are not repeated. Throws InvalidInput as
/// FileValue does.
Scenario TwinScenario(const Flight& flight, const Trajectory& estimated,
                      const std::vector<GapCause>& causes, const Eigen::Vector3d& boresight_rad);

}  // namespace dn
