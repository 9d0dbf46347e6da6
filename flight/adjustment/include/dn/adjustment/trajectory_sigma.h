#pragma once

#include <dn/adjustment/result.h>

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace dn {

/// Rotations from the tangents of a node's blocks to the axes of reported standard deviations.
struct NodeAxes {
  Eigen::Matrix3d R_enu_m;        ///< map to east, north, up at the node
  Eigen::Matrix3d rph_from_body;  ///< attitude error in body to roll, pitch, heading
};
NodeAxes FindNodeAxes(const FlightNetwork& network, std::size_t node);

/// Returns the standard deviations of the poses at the nodes. `marginals` must have its selected
/// inverse.
std::vector<TrajectorySigma> TrajectorySigmas(const FlightNetwork& network,
                                              const Marginals& marginals);

}  // namespace dn
