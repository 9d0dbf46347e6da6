#pragma once

#include <dn/flight/flight.h>

#include <Eigen/Core>

namespace dn::internal {

/// What the estimator takes for the noise of GNSS positions, median over the epochs, east, north,
/// up, m. The flight must have GNSS.
Eigen::Vector3d MedianGnssSigma(const Flight& flight);

/// Per coordinate of a pair's difference, m; the median where the pairs bring their own. The flight
/// must have pairs.
double MedianPairSigma(const Flight& flight);

}  // namespace dn::internal
