#pragma once

#include <dn/files/flight.h>

#include <Eigen/Core>

namespace dn::diagnosis_internal {

/// Returns the median over the epochs of the noise that the estimator assumes for GNSS positions:
/// east, north, up, m. The flight must have GNSS data.
Eigen::Vector3d MedianGnssSigma(const Flight& flight);

/// Returns the noise per coordinate of a pair's difference, m: the median if most pairs state their
/// own, else lidar.sigma_p_m. The flight must have pairs.
double MedianPairSigma(const Flight& flight);

}  // namespace dn::diagnosis_internal
