#pragma once

#include <dn/builder/gauss_helmert_flight.h>

namespace dn::internal {

/// What the misclosures of a Gauss-Helmert adjustment say against its model: their size against the
/// stated noise, the share of outliers, the size of the angles, the stated prior.
ModelCheck CheckGaussHelmert(const GaussHelmertCalibration& calibration);

}  // namespace dn::internal
