#pragma once

#include <dn/calibration/adjust.h>
#include <dn/flight/flight.h>

namespace dn::internal {

/// An adjustment in which whatever may tell of an effect is kept: least squares over all GNSS epochs
/// but single gross errors, and over all pairs but those that cannot be noise.
struct EvidenceAdjustment {
  Adjustment adjustment;
  long gnss_left_out = 0;  ///< single epochs
};

/// `options.stages` is not used. Throws as Adjust.
EvidenceAdjustment AdjustForEvidence(const Flight& flight, const AdjustOptions& options);

}  // namespace dn::internal
