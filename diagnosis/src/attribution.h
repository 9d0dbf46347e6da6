#pragma once

#include <dn/gap/diagnose.h>

#include <memory>
#include <string>
#include <vector>

#include "explained_flight.h"
#include "slots.h"

namespace dn::internal {

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
/// `threshold_nats`; then tries for every cause whether another explains its part better. Of a flight
/// where no gap was detected nothing is taken.
Attribution Attribute(const Explainer& explainer, std::unique_ptr<ExplainedFlight> base,
                      bool detected, double threshold_nats);

}  // namespace dn::internal
