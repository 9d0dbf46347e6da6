#pragma once

#include <Eigen/Core>
#include <vector>

namespace dn::matching_internal {

/// Throws InvalidInput with the name and value of the length unless it is positive and finite.
void CheckPositive(const char* name, double length_m);

/// Throws InvalidInput with the first point that has a coordinate that is not finite or exceeds
/// bound_m in magnitude.
void CheckPoints(const std::vector<Eigen::Vector3d>& points_m, double bound_m);

}  // namespace dn::matching_internal
