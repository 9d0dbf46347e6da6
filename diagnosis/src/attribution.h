#pragma once

#include <dn/diagnosis/diagnose.h>

#include <memory>
#include <string>
#include <vector>

#include "competing_hypotheses.h"
#include "explained_flight.h"

namespace dn::internal {

/// Result of the forward selection: the effects that explain a flight.
struct SelectedModel {
  std::unique_ptr<ExtendedFit> base;   ///< without any effects
  std::unique_ptr<ExtendedFit> final;  ///< with all causes; null if there are none
  std::vector<GapCause> causes;        ///< in the order of selection
  /// Competing hypotheses of each cause, or a single set without a cause if there are no causes.
  std::vector<CompetingHypotheses> slots;
  double explained_nats = 0.0;    ///< total evidence of the causes
  double discrepancy_nats = 0.0;  ///< largest evidence of an unmodelled discrepancy, at `base`
  std::vector<std::string> notes;

  const ExtendedFit& last() const { return final ? *final : *base; }
};

/// Selects effects forward. Adds the most probable effect, adjusts again with it, and repeats while
/// the evidence exceeds `threshold_nats`. Then checks for every cause whether another effect
/// explains its part better. Selects no effect if no gap was detected.
SelectedModel SelectEffects(const ExtendedModelFitter& model_fitter,
                            std::unique_ptr<ExtendedFit> base, bool detected,
                            double threshold_nats);

}  // namespace dn::internal
