#pragma once

#include <dn/geo/trajectory.h>

#include <Eigen/Core>
#include <filesystem>
#include <vector>

namespace dn::internal {

/// See ReadTrajectory; one function per format.
Trajectory ReadSbet(const std::filesystem::path& file);
Trajectory ReadTrajectoryText(const std::filesystem::path& file, const TrajectoryColumns& columns);

/// Velocities north, east, down in m/s by differentiating the positions of at least two points
/// with increasing times: the parabola through each point and its neighbours.
std::vector<Eigen::Vector3d> DifferentiatedVelocities(const std::vector<NavPoint>& points);

/// Difference in m/s between each of several lists of velocities north, east, down and the
/// positions: both averaged over windows of a second, the 95 % quantile over the windows.
std::vector<double> VelocityMisfits(const std::vector<NavPoint>& points,
                                    const std::vector<std::vector<Eigen::Vector3d>>& v_ned_mps);

}  // namespace dn::internal
