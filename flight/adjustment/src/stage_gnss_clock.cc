#include <dn/calibration/stages.h>

#include <algorithm>
#include <cmath>

#include "network_at.h"

namespace dn {
namespace {

// Beyond it the way from a node to an epoch is not that of constant acceleration, to a tenth of a
// millimetre in strong turbulence (GnssAntenna).
constexpr double kLongestWayS = 5e-3;
constexpr int kMostLinks = 10;

double LongestWay(const FlightNetwork& network) {
  const CalibrationState calibration = network.Calibration();
  double longest_s = 0.0;
  for (const FlightNetwork::GnssEdge& edge : network.gnss_edges) {
    const double tag_s = network.flight().gnss->epochs[edge.epoch].t_s;
    longest_s = std::max(
        longest_s, std::abs(GnssEpochTime(calibration, tag_s) - network.nodes[edge.node].t_s));
  }
  return longest_s;
}

}  // namespace

void SettleGnssClock(AdjustmentRun& run) {
  for (int k = 0; k < kMostLinks && LongestWay(run.network()) > kLongestWayS; ++k) {
    run.result().network = internal::NetworkAt(run, run.network().Calibration());
    SolveInsGnss(run);
  }
}

}  // namespace dn
