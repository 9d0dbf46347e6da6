#pragma once

#include <dn/gap/diagnosis.h>

#include <string>
#include <vector>

#include "screen.h"

namespace dn::internal {

/// One cause of the verdict among its rivals, all other causes being there.
struct Slot {
  std::string effect;                  ///< empty: there is no cause
  std::vector<ScreenedEffect> rivals;  ///< all effects of the screen without it, itself among them
  std::vector<double> posterior;       ///< of each
  std::vector<std::string> credible_set;  ///< 95 %, physical names
  double generic_posterior = 0.0;         ///< of a discrepancy without a name
};

/// A cause among its rivals, itself among them.
Slot MakeSlot(const std::string& effect, const std::vector<ScreenedEffect>& rivals);

/// Probabilities of effects, of nothing at last; see docs/guides/gap.md.
std::vector<double> Posterior(const std::vector<ScreenedEffect>& effects);

/// The effect of a name; null where it is not among them.
const ScreenedEffect* Find(const std::vector<ScreenedEffect>& effects, const std::string& name);
/// The evidence of an effect; minus infinity where it is not among them.
double EvidenceOf(const std::vector<ScreenedEffect>& effects, const std::string& name);
/// The likeliest discrepancy without a name; null without any.
const ScreenedEffect* BestGeneric(const std::vector<ScreenedEffect>& effects);
/// Most evidence of one; 0 without any.
double GenericEvidence(const std::vector<ScreenedEffect>& effects);
/// The likeliest with a name, of effects sorted by evidence; null without any.
const ScreenedEffect* BestPhysical(const std::vector<ScreenedEffect>& effects);

/// Causes and discrepancies of a diagnosis: every effect of a screen with its probability over all
/// slots; those of `named` first, with the probability and the rivals of their slots.
void FillCauses(const std::vector<ScreenedEffect>& screened, const std::vector<Slot>& slots,
                const std::vector<GapCause>& named, GapDiagnosis* diagnosis);

/// Makes the probabilities of causes those that have been borne out. Physics that the table lacks
/// looks like its nearest relative there, whatever the evidence; the more likely so where something is
/// left that no effect explains.
void AllowForOutsiders(const GapVerdict& verdict, std::vector<GapCause>* causes);

/// What decides the kind of a verdict.
struct Decision {
  bool detected = false;
  bool discrepancy_is_better = false;  ///< than the effects named
  bool something_left = false;         ///< beside them
};

/// The verdict on effects with a name, each in its slot. A name is not given where a discrepancy
/// without one is likelier than all names of the slot together and fits the data as well.
GapVerdict Decide(const Decision& decision, const std::vector<std::string>& named,
                  const std::vector<Slot>& slots);

}  // namespace dn::internal
