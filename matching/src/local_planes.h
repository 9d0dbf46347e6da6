#pragma once

#include <dn/matching/point_cloud.h>

#include <Eigen/Core>
#include <vector>

#include "point_tree.h"

namespace dn::matching_internal {

/// Does what dn::FitLocalPlanes does, with a given tree of the points and without checks.
std::vector<LocalPlane> FitLocalPlanes(const std::vector<Eigen::Vector3d>& points_m,
                                       const PointTree& tree, const std::vector<std::size_t>& at,
                                       double radius_m);

}  // namespace dn::matching_internal
