#pragma once

#include <string>
#include <vector>

#include "hypothesis_evidence.h"

namespace dn::diagnosis_internal {

/// Returns the effect of outliers if `found` of `of_all` measurements were rejected, and good data
/// lose the fraction `usual`. The log evidence follows from the Poisson distribution, averaged over
/// the possible fractions of outliers.
///
/// `lengths_m` are the misclosures of the rejected measurements. Outlier lengths are assumed to be
/// uniform up to the size, the largest one found. Outliers too short to be rejected are added to
/// the estimated fraction; it follows from the mean of the lengths.
HypothesisEvidence OutlierEffect(EffectId id, long found, long of_all, double usual,
                                 const std::vector<double>& lengths_m);

/// Returns the variance that outliers too short to be rejected add to the measurements in use, per
/// axis, in units of sigma_m^2. With lengths uniform up to size_m, those below c = norm * sigma_m
/// remain:
///
///   share * c / size * c^2 / 3 / 3 / sigma^2.
double ShortOutlierVariance(double share, double size_m, double sigma_m, double norm);

}  // namespace dn::diagnosis_internal
