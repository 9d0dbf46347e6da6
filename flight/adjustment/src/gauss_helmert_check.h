#pragma once

#include <dn/adjustment/gauss_helmert_flight.h>

#include <vector>

namespace dn::internal {

/// Tests the model of a Gauss-Helmert adjustment with its misclosures. Compares the size of the
/// misclosures with the stated noise, and looks for effects and unmodelled discrepancies of the
/// lidar (FindEffects). Also tests the share of outliers, the size of the angles, and the stated
/// prior. The boresight of `calibration` must be set.
ModelCheck CheckGaussHelmert(const Flight& flight, const std::vector<StripInterval>& strips,
                             const GaussHelmertCalibration& calibration);

}  // namespace dn::internal
