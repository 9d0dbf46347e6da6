#include "gnss_fit.h"

#include <dn/navigation/robust_scale.h>

#include <vector>

namespace dn::adjustment_internal {
namespace {

constexpr double kHopelessSigmas = 30.0;
constexpr double kLargestShareLeft = 0.5;

/// Returns the squared norms of the whitened residuals of the positions in use.
std::vector<double> GnssNorms2(const FlightNetwork& network) {
  std::vector<double> norm2;
  for (const GnssEdge& edge : network.gnss().edges()) {
    Eigen::VectorXd r;
    if (!network.net().factor(edge.position).active) continue;
    if (network.net().EvaluateFactor(edge.position, &r)) norm2.push_back(r.squaredNorm());
  }
  return norm2;
}

}  // namespace

double Excess(const CostSummary& cost) {
  return 2.0 * cost.cost - static_cast<double>(cost.redundancy());
}

bool IsHopeless(const FlightNetwork& network) {
  const std::vector<double> norm2 = GnssNorms2(network);
  return !norm2.empty() && RobustVariance(norm2) > kHopelessSigmas * kHopelessSigmas;
}

bool ClockMayExplain(const FlightNetwork& network, double before, double after) {
  return after < kLargestShareLeft * before || !IsHopeless(network);
}

}  // namespace dn::adjustment_internal
