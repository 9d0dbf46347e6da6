#pragma once

#include <dn/builder/calibration_state.h>

#include <Eigen/Core>
#include <vector>

namespace dn {

/// Returns the Jacobian of the gravitation at p_m for every effect on gravitation, in the order of
/// the blocks of the factors.
std::vector<GravitationBasis> GravitationJacobians(const CalibrationState& calibration,
                                                   const Eigen::Vector3d& p_m);

}  // namespace dn
