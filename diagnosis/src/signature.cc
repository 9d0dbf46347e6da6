#include <dn/adjustment/stages.h>
#include <dn/diagnosis/signature.h>
#include <dn/solvers/marginals.h>

#include <algorithm>

#include "screen.h"

namespace dn {
namespace {

Adjustment AdjustWithAllData(const Flight& flight, const GapOptions& options) {
  AdjustOptions adjust;
  adjust.with_pairs = flight.pairs.has_value() && !flight.pairs->pairs.empty();
  adjust.threads = options.threads;
  adjust.interrupted = options.interrupted;
  adjust.stages = DefaultStages(adjust.with_pairs);
  adjust.stages.erase(FindStage("GNSS screening", &adjust.stages));
  if (adjust.with_pairs) adjust.stages.erase(FindStage("pair rejection", &adjust.stages));
  return Adjust(flight, adjust);
}

}  // namespace

Signature ComputeSignature(const Flight& with, const Flight& without, const GapOptions& options) {
  options.Validate();
  const double cost_without = AdjustWithAllData(without, options).cost;
  const Adjustment adjusted = AdjustWithAllData(with, options);
  Signature signature;
  signature.lambda = 2.0 * std::max(0.0, adjusted.cost - cost_without);
  const Marginals marginals(adjusted.network->net(), {.threads = options.threads});
  const diagnosis_internal::Screen screen(*adjusted.network, marginals,
                                          diagnosis_internal::MakeLibraryOptions(options));
  double most = 0.0;
  for (const diagnosis_internal::HypothesisEvidence& effect : screen.EffectsInOrder()) {
    if (!effect.physical() || effect.statistic <= most) continue;
    most = effect.statistic;
    signature.nearest = effect.name;
  }
  signature.lambda_left = std::max(0.0, signature.lambda - most);
  return signature;
}

}  // namespace dn
