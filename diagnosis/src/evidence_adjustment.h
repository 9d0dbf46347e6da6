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

/// Treatment of outliers among the pairs.
enum class PairOutliers {
  kReject,   ///< a robust adjustment finds and rejects them
  kNotThere  ///< none are searched for, which saves half of the time
};

/// Returns the node rate within strips of all networks of a diagnosis, Hz: that of the
/// configuration, or else AutoNodeRateHz for a diagnosis. Its networks then have a third of the
/// nodes of the result where pairs are dense, and are compared at one rate.
double DiagnosisNodeRateHz(const Flight& flight);

/// Adjusts a flight this way. Ignores `options.stages`. Throws as Adjust.
EvidenceAdjustment AdjustForEvidence(const Flight& flight, const AdjustOptions& options,
                                     PairOutliers outliers = PairOutliers::kReject);

}  // namespace dn::diagnosis_internal
