#include "refine_times.h"

#include <dn/effects/effect_table.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "discrepancies.h"
#include "evidence.h"
#include "network_hypotheses.h"

namespace dn::diagnosis_internal {
namespace {

constexpr int kFineCells = 16;  // on either side of an end
// A step of fewer GNSS epochs counts as outliers, and its size is not estimated.
constexpr std::ptrdiff_t kFewestEpochs = 4;

/// Cells in which a step may begin or end, and the ranges of cells that are tried.
struct FineCells {
  TimeCells cells;
  std::vector<std::pair<int, int>> ranges;
};

/// Appends fine cells from `reach_s` before to `reach_s` after a time. Returns the index of the
/// first one.
int AppendFine(double t_s, double reach_s, TimeCells* cells) {
  const int first = cells->count();
  cells->Append(t_s - reach_s, reach_s / kFineCells, 2 * kFineCells);
  return first;
}

FineCells AroundStart(double t0_s, double reach_s, double begin_s) {
  FineCells fine;
  fine.cells.start_s.push_back(std::min(begin_s, t0_s - reach_s) - 1.0);
  const int first = AppendFine(t0_s, reach_s, &fine.cells);
  fine.cells.start_s.push_back(t0_s + reach_s);
  for (int k = first; k < fine.cells.count(); ++k) fine.ranges.emplace_back(k, fine.cells.count());
  return fine;
}

FineCells AroundWindow(const std::pair<double, double>& window_s, double reach_s) {
  FineCells fine;
  const double reach = std::min(reach_s, 0.5 * (window_s.second - window_s.first));
  fine.cells.start_s.push_back(window_s.first - reach - 1.0);
  const int begin = AppendFine(window_s.first, reach, &fine.cells);
  fine.cells.start_s.push_back(window_s.first + reach);
  const int end = AppendFine(window_s.second, reach, &fine.cells);
  fine.cells.start_s.push_back(window_s.second + reach);
  std::sort(fine.cells.start_s.begin(), fine.cells.start_s.end());
  for (int first = begin; first <= begin + 2 * kFineCells; ++first) {
    for (int past = end; past <= end + 2 * kFineCells; ++past) {
      if (past > first) fine.ranges.emplace_back(first, past);
    }
  }
  return fine;
}

std::ptrdiff_t EpochsWithin(const FlightNetwork& network,
                            const std::pair<double, double>& window_s) {
  const std::vector<MapGnssEpoch>& epochs = network.flight().gnss->epochs;
  return std::count_if(epochs.begin(), epochs.end(), [&](const MapGnssEpoch& epoch) {
    return epoch.t_s >= window_s.first && epoch.t_s < window_s.second;
  });
}

double CellLength(const FlightNetwork& network, EffectId effect) {
  if (effect == EffectId::kBoresightStep) return 1.5 * BoresightCellS(FindStrips(network.flight()));
  return GnssCellS(network.trajectory().node_times().back() -
                   network.trajectory().node_times().front());
}

}  // namespace

void RefineTimes(const FlightNetwork& network, const Marginals& marginals, int threads,
                 HypothesisEvidence* effect) {
  const bool start = effect->id == EffectId::kBoresightStep;
  if (!start && effect->id != EffectId::kGnssPositionStep) return;
  const double reach_s = CellLength(network, *effect->id);
  const FineCells fine =
      start ? AroundStart(*effect->times.t0_s, reach_s, network.trajectory().node_times().front())
            : AroundWindow(*effect->times.window_s, reach_s);
  const Library found = MakeNetworkHypotheses(
      network, threads, {start ? BoresightByCell(fine.cells) : GnssByCell(fine.cells)});
  if (found.blocks.back().empty()) return;
  const std::vector<BlockId> watched =
      start || !network.pairs().edges().empty()
          ? std::vector<BlockId>{network.calibration().boresight().id}
          : std::vector<BlockId>{};
  const JointScore score = ScoreEffects(marginals, {found.blocks.back()}, watched);
  Hypothesis step = MakeHypothesis(*effect->id);
  double best = -std::numeric_limits<double>::infinity();
  for (const auto& [first, past] : fine.ranges) {
    const auto last = static_cast<std::size_t>(std::min(past, fine.cells.count() - 1));
    const std::pair<double, double> range_s{fine.cells.start_s[static_cast<std::size_t>(first)],
                                            fine.cells.start_s[last]};
    if (!start && EpochsWithin(network, range_s) < kFewestEpochs) continue;
    step.cells = CellRange{first, past};
    const double evidence = LogEvidence(step, score);
    if (evidence <= best) continue;
    best = evidence;
    const ScoreTest test = TestHypothesis(step, score);
    effect->estimate = test.estimate;
    effect->sigma = ComponentSigmas(test);
    if (score.shift.rows() == 3) effect->boresight_rad = SelectShift(step, score) * test.estimate;
    if (start) {
      effect->times.t0_s = range_s.first;
    } else {
      effect->times.window_s = range_s;
    }
  }
}

}  // namespace dn::diagnosis_internal
