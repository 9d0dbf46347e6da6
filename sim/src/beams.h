#pragma once

#include <dn/sim/scenario.h>

#include <Eigen/Core>
#include <cstdint>

namespace dn {

/// Returns the scenario with the errors of all beams: those that it states, and drawn ones for the
/// others.
Scenario WithBeamErrors(Scenario scenario, std::uint64_t seed);

/// Returns the true angle of a beam toward +scan_axis from the plane across it, rad.
double TrueBeamAngle(const BeamScenario& beams, int beam);

/// Returns the laser vector that the scanner reports for a true one in the sensor frame. It has the
/// assumed angle of the beam, and the error of its range. For kNoBeam it is the true one.
Eigen::Vector3d ReportedByBeam(const LidarScenario& lidar, int beam, const Eigen::Vector3d& u_s);

}  // namespace dn
