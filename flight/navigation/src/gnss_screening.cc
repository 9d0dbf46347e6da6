#include <dn/navigation/gnss_screening.h>
#include <dn/navigation/robust_scale.h>
#include <dn/solvers/prediction.h>

#include <algorithm>
#include <cstddef>
#include <iterator>

namespace dn {
namespace {

// Number of epochs on each side of a measurement that form its neighbourhood.
constexpr std::size_t kNeighbours = 10;
constexpr double kShareOfWorst = 0.5;

}  // namespace

GnssScreening::GnssScreening(const FlightNetwork& network, const Marginals& marginals)
    : positions_(Judge(network, marginals, &GnssEdge::position)),
      velocities_(Judge(network, marginals, &GnssEdge::velocity)) {}

std::vector<GnssScreening::Judged> GnssScreening::Judge(const FlightNetwork& network,
                                                        const Marginals& marginals,
                                                        FactorId GnssEdge::*which) {
  std::vector<Judged> judged;
  for (const GnssEdge& edge : network.gnss().edges()) {
    const FactorId id = edge.*which;
    if (id < 0) continue;
    const Prediction prediction = PredictFactor(marginals, id);
    if (!prediction.determined) continue;
    const bool active = marginals.linearized().FindRows(id).has_value();
    judged.push_back({id, prediction.statistic, active});
  }
  return judged;
}

double GnssScreening::Worst() const {
  double worst = 0.0;
  for (const auto* judged : {&positions_, &velocities_}) {
    for (const Judged& one : *judged) {
      if (one.active) worst = std::max(worst, one.statistic);
    }
  }
  return worst;
}

std::vector<FactorId> GnssScreening::WorstPositions(std::size_t count) const {
  std::vector<Judged> active;
  std::copy_if(positions_.begin(), positions_.end(), std::back_inserter(active),
               [](const Judged& one) { return one.active; });
  count = std::min(count, active.size());
  std::partial_sort(active.begin(), active.begin() + static_cast<std::ptrdiff_t>(count),
                    active.end(),
                    [](const Judged& a, const Judged& b) { return a.statistic > b.statistic; });
  std::vector<FactorId> ids;
  for (std::size_t k = 0; k < count; ++k) ids.push_back(active[k].id);
  return ids;
}

// Considers active measurements only, because the others do not influence their neighbours.
double GnssScreening::WorstNearby(const std::vector<Judged>& judged, std::size_t k) {
  const std::size_t first = k > kNeighbours ? k - kNeighbours : 0;
  const std::size_t past = std::min(judged.size(), k + kNeighbours + 1);
  double worst = 0.0;
  for (std::size_t i = first; i < past; ++i) {
    if (judged[i].active) worst = std::max(worst, judged[i].statistic);
  }
  return worst;
}

long GnssScreening::Apply(const std::vector<Judged>& judged, const std::set<FactorId>& out_for_good,
                          double noise_ratio, Network* net) {
  if (judged.empty()) return 0;
  std::vector<double> statistics;
  for (const Judged& one : judged) statistics.push_back(one.statistic);
  const double gross = kOutlierNorm * kOutlierNorm * noise_ratio * RobustVariance(statistics);
  long changes = 0;
  for (std::size_t k = 0; k < judged.size(); ++k) {
    const bool agrees = judged[k].statistic <= gross;
    if (judged[k].active == agrees) continue;
    const bool among_the_worst = judged[k].statistic >= kShareOfWorst * WorstNearby(judged, k);
    if (judged[k].active ? !among_the_worst : out_for_good.count(judged[k].id) > 0) continue;
    net->SetActive(judged[k].id, agrees);
    ++changes;
  }
  return changes;
}

long GnssScreening::Apply(const std::set<FactorId>& out_for_good, double noise_ratio,
                          Network* net) const {
  return Apply(positions_, out_for_good, noise_ratio, net) +
         Apply(velocities_, out_for_good, 1.0, net);
}

}  // namespace dn
