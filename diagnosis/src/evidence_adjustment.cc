#include "evidence_adjustment.h"

#include <dn/adjustment/stages.h>
#include <dn/builder/flight_nodes.h>
#include <dn/navigation/robust_scale.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/prediction.h>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace dn::diagnosis_internal {
namespace {

// An outlier is isolated. An effect of the flight or the receiver also changes the neighbouring
// epochs in the same direction, by at least this fraction.
constexpr double kNeighbourShare = 0.5;
constexpr int kMostPasses = 8;

struct Judged {
  FactorId id = -1;
  double statistic = 0.0;
  Eigen::VectorXd error;  ///< prediction error, whitened by the sigmas of the measurement
};

/// Returns the fraction of an error that its neighbour shares.
double SharedPart(const Judged& one, const Judged& neighbour) {
  return one.error.dot(neighbour.error) / one.error.squaredNorm();
}

std::vector<Judged> Judge(const FlightNetwork& network, const Marginals& marginals,
                          FactorId GnssEdge::*which) {
  std::vector<Judged> judged;
  for (const GnssEdge& edge : network.gnss().edges()) {
    const FactorId id = edge.*which;
    if (id < 0 || !network.net().factor(id).active) continue;
    const Prediction prediction = PredictFactor(marginals, id);
    if (prediction.determined) judged.push_back({id, prediction.statistic, prediction.residual});
  }
  return judged;
}

long RejectIsolated(const std::vector<Judged>& judged, Network* net) {
  if (judged.empty()) return 0;
  std::vector<double> statistics;
  for (const Judged& one : judged) statistics.push_back(one.statistic);
  const double gross = kOutlierNorm * kOutlierNorm * RobustVariance(statistics);
  long rejected = 0;
  for (std::size_t k = 0; k < judged.size(); ++k) {
    const bool shared =
        (k > 0 && SharedPart(judged[k], judged[k - 1]) > kNeighbourShare) ||
        (k + 1 < judged.size() && SharedPart(judged[k], judged[k + 1]) > kNeighbourShare);
    if (judged[k].statistic < gross || shared) continue;
    net->SetActive(judged[k].id, false);
    ++rejected;
  }
  return rejected;
}

long RejectGnssOutliers(AdjustmentRun& run) {
  long rejected = 0;
  for (int pass = 0; pass < kMostPasses; ++pass) {
    run.Announce("GNSS, outliers");
    Marginals marginals(run.network().net(),
                        {.threads = run.options().threads, .analysis = run.result().analysis});
    marginals.ComputeSelectedInverse();
    long now = 0;
    for (const auto which : {&GnssEdge::position, &GnssEdge::velocity}) {
      now += RejectIsolated(Judge(run.network(), marginals, which), &run.network().net());
    }
    if (now == 0) break;
    rejected += now;
    run.Solve("INS/GNSS, outliers removed", run.options().max_iterations);
  }
  return rejected;
}

}  // namespace

double DiagnosisNodeRateHz(const Flight& flight) {
  return flight.config.network.node_rate_hz.value_or(
      AutoNodeRateHz(flight, NodeRateUse::kDiagnosis));
}

EvidenceAdjustment AdjustForEvidence(const Flight& flight, const AdjustOptions& options,
                                     PairOutliers outliers) {
  EvidenceAdjustment out;
  AdjustOptions own = options;
  own.stages = DefaultStages(options.with_pairs);
  if (options.with_pairs && outliers == PairOutliers::kNotThere) {
    for (const char* name : {"lidar, robust", "pair rejection"}) {
      own.stages.erase(FindStage(name, &own.stages));
    }
  }
  FindStage("GNSS screening", &own.stages)->run = [&](AdjustmentRun& run) {
    out.gnss_left_out = RejectGnssOutliers(run);
  };
  out.adjustment = Adjust(flight, own);
  return out;
}

}  // namespace dn::diagnosis_internal
