#pragma once

#include <Eigen/Core>
#include <vector>

namespace dn::internal {

/// Throws InvalidInput naming the length and its value unless it is positive and finite.
void CheckPositive(const char* name, double length_m);

/// Throws InvalidInput naming the first point with a coordinate that is not finite or whose
/// magnitude exceeds bound_m.
void CheckPoints(const std::vector<Eigen::Vector3d>& points_m, double bound_m);

}  // namespace dn::internal
