#include "refine_times.h"

#include <dn/calibration/candidate_effects.h>
#include <dn/effects/effect_table.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "generic_effects.h"

namespace dn::internal {
namespace {

constexpr int kFineCells = 16;  // to either side of an end

/// Cells over which a step may begin or end, and the sums of them that are tried.
struct FineCells {
  TimeCells cells;
  std::vector<std::pair<int, int>> ranges;
};

/// Fine cells from half a cell before to half a cell after a time, and where they begin.
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

double CellLength(const FlightNetwork& network, const std::string& name) {
  if (name == "boresight_step") return 1.5 * BoresightCellS(FindStrips(network.flight()));
  return GnssCellS(network.node_times().back() - network.node_times().front());
}

}  // namespace

void RefineTimes(const FlightNetwork& network, const Marginals& marginals, int threads,
                 ScreenedEffect* effect) {
  const bool start = effect->name == "boresight_step";
  if (!start && effect->name != "gnss_position_step") return;
  const double reach_s = CellLength(network, effect->name);
  const FineCells fine =
      start ? AroundStart(*effect->times.t0_s, reach_s, network.node_times().front())
            : AroundWindow(*effect->times.window_s, reach_s);
  const OwnEffect own = start ? BoresightByCell(fine.cells) : GnssByCell(fine.cells);
  std::vector<CandidateEffect> found = CandidateEffects(network, threads, {own});
  if (found.empty() || found.back().model.empty()) return;
  const std::vector<BlockId> watched = start || !network.pair_edges.empty()
                                           ? std::vector<BlockId>{network.boresight.id}
                                           : std::vector<BlockId>{};
  const JointScore score = ScoreEffects(marginals, {found.back().model}, watched);
  Candidate candidate;
  const EffectSpec& spec = *FindEffect(effect->name);
  candidate.typical.resize(3);
  for (std::size_t k = 0; k < 3; ++k) {
    candidate.typical[static_cast<Eigen::Index>(k)] = spec.components[k].typical_si();
  }
  double best = -std::numeric_limits<double>::infinity();
  for (const auto& [first, past] : fine.ranges) {
    candidate.cells = CellRange{first, past};
    const Eigen::MatrixXd A = InformationOf(candidate, score);
    const Eigen::VectorXd s = ScoreOf(candidate, score, score.s);
    const double evidence = EvidenceForm(A, candidate.typical).LogEvidence(s);
    if (evidence <= best) continue;
    best = evidence;
    const ScoreTest test = TestScore(s, A, SignatureOf(candidate, score));
    effect->estimate = test.estimate;
    effect->sigma = test.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
    if (score.shift.rows() == 3) effect->boresight_rad = ShiftOf(candidate, score) * test.estimate;
    const double from_s = fine.cells.start_s[static_cast<std::size_t>(first)];
    if (start) {
      effect->times.t0_s = from_s;
    } else {
      const auto last = static_cast<std::size_t>(std::min(past, fine.cells.count() - 1));
      effect->times.window_s = {{from_s, fine.cells.start_s[last]}};
    }
  }
}

}  // namespace dn::internal
