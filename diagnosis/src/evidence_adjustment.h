#pragma once

#include <dn/adjustment/adjust.h>
#include <dn/files/flight.h>

namespace dn::diagnosis_internal {

/// An adjustment that keeps all data that may show an effect. It is a least-squares fit of all GNSS
/// epochs except isolated outliers, and all pairs except those that cannot be noise.
struct EvidenceAdjustment {
  Adjustment adjustment;
  long gnss_left_out = 0;  ///< isolated epochs
};

/// Adjusts a flight this way. Ignores `options.stages`. Throws as Adjust.
EvidenceAdjustment AdjustForEvidence(const Flight& flight, const AdjustOptions& options);

}  // namespace dn::diagnosis_internal
