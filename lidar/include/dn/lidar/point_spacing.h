#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace dn {

/// Returns the ground sampling distance of a strip, m: the root of the mean area of a point. The
/// area is that of the cells of a horizontal grid that contain points, 30 or more each. `p_m`: a
/// sample that leaves no such cell empty; `points`: their number before sampling. Returns nullopt
/// if cells of 128 m have fewer than 30 points.
std::optional<double> PointSpacing(const std::vector<Eigen::Vector3d>& p_m, double points);

}  // namespace dn
