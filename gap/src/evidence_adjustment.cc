#include "evidence_adjustment.h"

#include <dn/calibration/stages.h>
#include <dn/navigation/robust_scale.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/prediction.h>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace dn::internal {
namespace {

// A gross error stands by itself: an effect of the flight or the receiver shows in its neighbours.
constexpr double kNeighbourShare = 0.25;
constexpr int kMostPasses = 8;

struct Judged {
  FactorId id = -1;
  double statistic = 0.0;
};

std::vector<Judged> Judge(const FlightNetwork& network, const Marginals& marginals,
                          FactorId FlightNetwork::GnssEdge::*which) {
  std::vector<Judged> judged;
  for (const FlightNetwork::GnssEdge& edge : network.gnss_edges) {
    const FactorId id = edge.*which;
    if (id < 0 || !network.net.factor(id).active) continue;
    const Prediction prediction = PredictFactor(marginals, id);
    if (prediction.determined) judged.push_back({id, prediction.statistic});
  }
  return judged;
}

long TakeOutSingles(const std::vector<Judged>& judged, Network* net) {
  if (judged.empty()) return 0;
  std::vector<double> statistics;
  for (const Judged& one : judged) statistics.push_back(one.statistic);
  const double gross = kGrossNorm * kGrossNorm * RobustVariance(statistics);
  const auto near = [&](std::size_t k, std::ptrdiff_t step) {
    const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(k) + step;
    const bool inside = at >= 0 && at < static_cast<std::ptrdiff_t>(judged.size());
    return inside ? judged[static_cast<std::size_t>(at)].statistic : 0.0;
  };
  long taken_out = 0;
  for (std::size_t k = 0; k < judged.size(); ++k) {
    const double alone = kNeighbourShare * judged[k].statistic;
    if (judged[k].statistic < gross || near(k, -1) > alone || near(k, 1) > alone) continue;
    net->SetActive(judged[k].id, false);
    ++taken_out;
  }
  return taken_out;
}

long TakeOutGrossGnss(AdjustmentRun& run) {
  long taken_out = 0;
  for (int pass = 0; pass < kMostPasses; ++pass) {
    run.Announce("GNSS, gross errors");
    Marginals marginals(run.network().net, {.threads = run.options().threads});
    marginals.ComputeSelectedInverse();
    long now = 0;
    for (const auto which :
         {&FlightNetwork::GnssEdge::position, &FlightNetwork::GnssEdge::velocity}) {
      now += TakeOutSingles(Judge(run.network(), marginals, which), &run.network().net);
    }
    if (now == 0) break;
    taken_out += now;
    run.Solve("INS/GNSS, gross errors out", run.options().max_iterations);
  }
  return taken_out;
}

}  // namespace

EvidenceAdjustment AdjustForEvidence(const Flight& flight, const AdjustOptions& options) {
  EvidenceAdjustment out;
  AdjustOptions own = options;
  own.stages = DefaultStages(options.with_pairs);
  StageNamed("GNSS screening", &own.stages)->run = [&](AdjustmentRun& run) {
    out.gnss_left_out = TakeOutGrossGnss(run);
  };
  out.adjustment = Adjust(flight, own);
  return out;
}

}  // namespace dn::internal
