#pragma once

#include <dn/gap/diagnose.h>

#include <memory>
#include <string>
#include <vector>

#include "explained_flight.h"

namespace dn::internal {

/// One cause of the verdict among its rivals, all other causes being there.
struct Slot {
  std::string effect;
  std::vector<ScreenedEffect> rivals;  ///< all effects of the screen without it, itself among them
  std::vector<double> posterior;       ///< of each
  std::vector<std::string> credible_set;  ///< 95 %, physical names
  double generic_posterior = 0.0;         ///< of a discrepancy without a name
};

/// Which effects explain a flight.
struct Attribution {
  std::unique_ptr<ExplainedFlight> base;   ///< without any
  std::unique_ptr<ExplainedFlight> final;  ///< with all causes; null: there are none
  std::vector<GapCause> causes;            ///< in the order found
  std::vector<Slot> slots;                 ///< one per cause; one for none where there is no cause
  double explained_nats = 0.0;             ///< evidence of the causes together
  double generic_nats = 0.0;               ///< most of a discrepancy without a name, at the base
  std::vector<std::string> notes;

  const ExplainedFlight& last() const { return final ? *final : *base; }
};

/// Takes the likeliest effect, adjusts anew with it, and again, while there is evidence above
/// `threshold_nats`; then tries for every cause whether another explains its part better.
Attribution Attribute(const Explainer& explainer, std::unique_ptr<ExplainedFlight> base,
                      double threshold_nats);

/// A cause among its rivals, itself among them.
Slot MakeSlot(const std::string& effect, const std::vector<ScreenedEffect>& rivals);

/// Probabilities of effects, of nothing at last; see docs/gap.md.
std::vector<double> Posterior(const std::vector<ScreenedEffect>& effects);

}  // namespace dn::internal
