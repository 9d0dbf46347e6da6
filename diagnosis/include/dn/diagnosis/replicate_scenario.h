#pragma once

#include <dn/diagnosis/diagnosis.h>
#include <dn/files/flight.h>
#include <dn/geo/trajectory.h>
#include <dn/sim/scenario.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace dn {

/// Name of the trajectory file that a scenario of MakeReplicateScenario replays. The file is in the
/// folder of the scenario.
inline constexpr const char* kReplayTrajectoryFile = "trajectory.out";

/// Returns a scenario that flies a flight again with the given effects (a parametric bootstrap
/// replicate). The estimated trajectory and boresight become the truth. Strips, rates, the assumed
/// sensor noise, the mounting, lever arms, and the number and noise of the pairs are those of the
/// flight. The field of view and pattern of the scan, and the height and roughness of the ground,
/// are estimated from the pairs.
///
/// `flight` must have IMU and GNSS data. Data gaps are not reproduced. Throws InvalidInput if the
/// flight has none, or if ToFileValue rejects a cause.
Scenario MakeReplicateScenario(const Flight& flight, const Trajectory& estimated,
                               const std::vector<GapCause>& causes,
                               const Eigen::Vector3d& boresight_rad);

}  // namespace dn
