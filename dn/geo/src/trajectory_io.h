#pragma once

#include <dn/geo/trajectory.h>

#include <Eigen/Core>
#include <filesystem>
#include <vector>

namespace dn::geo_internal {

/// Reads a trajectory in one of the two formats; see ReadTrajectory.
Trajectory ReadSbet(const std::filesystem::path& file);
Trajectory ReadTrajectoryText(const std::filesystem::path& file, const TrajectoryColumns& columns);

/// Returns velocities north, east, down in m/s from the positions of at least two points with
/// increasing times. Each is the slope of the parabola through the point and its neighbours.
std::vector<Eigen::Vector3d> DifferentiatePositions(const std::vector<NavPoint>& points);

/// Returns the difference in m/s between the positions and each of several lists of velocities
/// north, east, down. Both are averaged over windows of one second; the result is the 95 % quantile
/// over the windows.
std::vector<double> VelocityMisfits(const std::vector<NavPoint>& points,
                                    const std::vector<std::vector<Eigen::Vector3d>>& v_ned_mps);

}  // namespace dn::geo_internal
