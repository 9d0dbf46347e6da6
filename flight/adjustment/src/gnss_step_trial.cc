#include "gnss_step_trial.h"

#include <dn/error.h>
#include <dn/interrupted.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "gnss_clock.h"
#include "gnss_fit.h"

namespace dn::adjustment_internal {
namespace {

constexpr int kMostTrials = 4;

/// A step of the tags of the GNSS epochs. The epochs near it may lie on either side.
struct TagStep {
  std::size_t first_unsure, first_after;  // indices of epochs
  double step_s;
};

TagStep FindTagStep(const FlightNetwork& network, const GnssMisfit& step) {
  const std::vector<GnssEdge>& edges = network.gnss().edges();
  const std::size_t unsure = StepSpacing(edges.size());
  return {edges[step.first - std::min(step.first, unsure)].epoch,
          edges[std::min(step.first + unsure, edges.size() - 1)].epoch, step.estimate[0]};
}

// Returns the epochs with their tags corrected, without those that are unsure or that the
// correction moves behind others.
std::vector<MapGnssEpoch> CorrectedEpochs(const std::vector<MapGnssEpoch>& epochs,
                                          const TagStep& step) {
  std::vector<MapGnssEpoch> corrected(
      epochs.begin(), epochs.begin() + static_cast<std::ptrdiff_t>(step.first_unsure));
  for (std::size_t e = step.first_after; e < epochs.size(); ++e) {
    MapGnssEpoch epoch = epochs[e];
    epoch.t_s -= step.step_s;
    if (corrected.empty() || epoch.t_s > corrected.back().t_s) corrected.push_back(epoch);
  }
  return corrected;
}

/// An INS/GNSS network of corrected tags.
struct Trial {
  double excess;
  double left_s;  ///< step that is left, 0 if there is none
};

Trial Try(const Flight& flight, const AdjustOptions& options) {
  AdjustmentRun run(flight, options);
  MakeNetwork(run);
  SolveInsGnss(run);
  SettleGnssClock(run);
  Marginals marginals(run.network().net(), {.threads = options.threads});
  marginals.ComputeSelectedInverse();
  const auto left = ExplainGnssMisfit(run.network(), marginals);
  const bool steps = left && left->cause == GnssMisfit::Cause::kClockStep;
  return {Excess(EvaluateCost(run.network().net(), options.threads)),
          steps ? left->estimate[0] : 0.0};
}

}  // namespace

bool StepExplains(AdjustmentRun& run, const GnssMisfit& misfit) {
  Flight flight = run.flight();
  if (run.has_swapped_network()) EstimateGnssClock(&flight.config);
  TagStep step = FindTagStep(run.network(), misfit);
  const auto try_step = [&](double step_s) {
    step.step_s = step_s;
    flight.gnss->epochs = CorrectedEpochs(run.flight().gnss->epochs, step);
    return Try(flight, run.options());
  };
  try {
    const double without = try_step(0.0).excess;
    const double least_gain = kExplainedShare * std::max(without, misfit.statistic);
    double step_s = misfit.estimate[0];
    for (int k = 0; k < kMostTrials; ++k) {
      const Trial trial = try_step(step_s);
      if (without - trial.excess > least_gain) return true;
      if (trial.left_s == 0.0) return false;
      step_s += trial.left_s;
    }
  } catch (const Interrupted&) {
    throw;
  } catch (const Error&) {  // the corrected data do not fit at all
  }
  return false;
}

}  // namespace dn::adjustment_internal
