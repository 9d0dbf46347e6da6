#pragma once

#include <dn/gap/diagnose.h>

namespace dn::internal {

/// Diagnoses the pairs of a flight on its given trajectory: effects of the lidar and its mount,
/// beside errors of the trajectory that last. What the trajectory hides is listed as such.
/// Unavailable where there are too few pairs or no trajectory. Throws as CalibrateGaussHelmert.
GapResult DiagnoseGaussHelmert(const Flight& flight, const GapOptions& options);

}  // namespace dn::internal
