#pragma once

#include <dn/diagnosis/diagnose.h>

namespace dn::internal {

/// Diagnoses the pairs of a flight on its given trajectory. Tests effects of the lidar and its
/// mount, with time-correlated trajectory errors in the model. Effects that the trajectory absorbs
/// are listed as undetectable at any size. The verdict is unavailable without a trajectory and with
/// too few pairs. Throws as CalibrateGaussHelmert.
GapResult DiagnoseGaussHelmert(const Flight& flight, const GapOptions& options);

}  // namespace dn::internal
