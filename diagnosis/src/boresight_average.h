#pragma once

#include <dn/diagnosis/diagnosis.h>
#include <dn/effects/unmodelled_prior.h>

#include <vector>

#include "competing_hypotheses.h"
#include "forward_selection.h"
#include "screen.h"

namespace dn::diagnosis_internal {

/// Sets the boresight of a fit, and that of each hypothesis which the fit lacks, to first order.
/// `of_fit` is that of the pure model; the effects with a prior become unknowns. The size of a
/// hypothesis is averaged over its prior. Noise and outliers do not move the boresight.
void SetBoresights(const Screen& screen, const UnmodelledPrior& prior,
                   const BoresightEstimate& of_fit, ExtendedFit* fit);

/// Returns the boresight over all hypotheses, each with its probability. They are the named
/// effects, each of them replaced by a competing hypothesis or absent, and `further` hypotheses.
/// `of_fit` is the boresight with all named effects in the model. The covariance contains that of
/// each hypothesis and the differences between them. Something outside the library that resembles
/// an effect may move the boresight in another way; this adds its differing share of the shift.
BoresightEstimate AverageBoresight(const BoresightEstimate& of_fit,
                                   const std::vector<CompetingHypotheses>& named,
                                   const CompetingHypotheses& further);

}  // namespace dn::diagnosis_internal
