#pragma once

#include <string>
#include <vector>

#include "screen.h"

namespace dn::internal {

/// Gross errors: of `of_all` measurements `found` were left out, where good data lose the share
/// `usual`. Log evidence by Poisson's distribution, the expected number likely of any size.
///
/// lengths_m: misclosures of what was left out. Gross errors are taken to be of any length up to
/// their size, the largest seen; those too short to stand out are added to the share that is
/// estimated, by how far the mean of the lengths lies above half of the size.
ScreenedEffect OutlierEffect(EffectId id, long found, long of_all, double usual,
                             const std::vector<double>& lengths_m);

/// Variance that gross errors which are too short to be left out add to the measurements in use, per
/// axis, in squares of sigma_m: of lengths uniform up to size_m, those below c = norm * sigma_m stay,
///
///   share * c / size * c^2 / 3 / 3 / sigma^2.
double VarianceOfShortOnes(double share, double size_m, double sigma_m, double norm);

}  // namespace dn::internal
