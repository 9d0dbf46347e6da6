#pragma once

#include <dn/calibration/gauss_helmert_flight.h>

#include <vector>

namespace dn::internal {

/// What the misclosures of a Gauss-Helmert adjustment say against its model: their size against the
/// stated noise, effects and departures of the lidar (FindEffects), the share of outliers, the size of the angles,
/// the stated prior. `calibration` must have its boresight.
ModelCheck CheckGaussHelmert(const Flight& flight, const std::vector<StripInterval>& strips,
                             const GaussHelmertCalibration& calibration);

}  // namespace dn::internal
