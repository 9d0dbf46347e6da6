#include "gnss_screening.h"

#include <dn/solvers/prediction.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "robust_scale.h"

namespace dn {
namespace {

// Norm of a standardised 3-vector that a good measurement exceeds once in 1.7 million: as much
// outside as five sigmas of a normal variable leave.
constexpr double kGrossNorm = 5.6;
// Epochs to either side among which only the worst are taken out in one pass.
constexpr std::size_t kNeighbours = 10;
constexpr double kShareOfWorst = 0.5;

struct Judged {
  FactorId id;
  double statistic;
};

std::vector<Judged> Judge(const FlightNetwork& network, const Marginals& marginals,
                          FactorId FlightNetwork::GnssEdge::*which) {
  std::vector<Judged> judged;
  for (const FlightNetwork::GnssEdge& edge : network.gnss_edges) {
    const FactorId id = edge.*which;
    if (id < 0) continue;
    const Prediction prediction = PredictFactor(network.net, id, marginals);
    if (prediction.determined) judged.push_back({id, prediction.statistic});
  }
  return judged;
}

double WorstNearby(const std::vector<Judged>& judged, std::size_t k) {
  const std::size_t first = k > kNeighbours ? k - kNeighbours : 0;
  const std::size_t past = std::min(judged.size(), k + kNeighbours + 1);
  double worst = 0.0;
  for (std::size_t i = first; i < past; ++i) worst = std::max(worst, judged[i].statistic);
  return worst;
}

long Screen(FlightNetwork* network, const std::vector<Judged>& judged) {
  if (judged.empty()) return 0;
  std::vector<double> statistics;
  for (const Judged& one : judged) statistics.push_back(one.statistic);
  const double gross = kGrossNorm * kGrossNorm * RobustVariance(statistics);
  long changes = 0;
  for (std::size_t k = 0; k < judged.size(); ++k) {
    const bool active = network->net.factor(judged[k].id).active;
    const bool agrees = judged[k].statistic <= gross;
    const bool among_the_worst = judged[k].statistic >= kShareOfWorst * WorstNearby(judged, k);
    if (active == agrees || (active && !among_the_worst)) continue;
    network->net.SetActive(judged[k].id, agrees);
    ++changes;
  }
  return changes;
}

}  // namespace

long ScreenGnss(FlightNetwork* network, const Marginals& marginals) {
  const auto positions = Judge(*network, marginals, &FlightNetwork::GnssEdge::position);
  const auto velocities = Judge(*network, marginals, &FlightNetwork::GnssEdge::velocity);
  return Screen(network, positions) + Screen(network, velocities);
}

}  // namespace dn
