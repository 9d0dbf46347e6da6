#include <dn/adjustment/stages.h>
#include <dn/builder/gnss_factors.h>

#include <algorithm>
#include <cmath>

#include "gnss_fit.h"
#include "network_at.h"

namespace dn {
namespace {

// GnssAntenna assumes constant acceleration between node and epoch. Up to this interval, its error
// is below a tenth of a millimetre in strong turbulence.
constexpr double kMaxNodeInterval_s = 5e-3;
constexpr int kMaxClockSteps = 10;

double LongestNodeInterval(const FlightNetwork& network) {
  const CalibrationState calibration = network.calibration().State();
  double longest_s = 0.0;
  for (const GnssEdge& edge : network.gnss().edges()) {
    const double tag_s = network.flight().gnss->epochs[edge.epoch].t_s;
    longest_s = std::max(
        longest_s, std::abs(GnssEpochTime(calibration, tag_s) - network.nodes()[edge.node].t_s));
  }
  return longest_s;
}

}  // namespace

void SettleGnssClock(AdjustmentRun& run) {
  for (int k = 0; k < kMaxClockSteps && LongestNodeInterval(run.network()) > kMaxNodeInterval_s;
       ++k) {
    const double before = run.result().cost;
    run.result().network =
        adjustment_internal::RemakeNetwork(run, run.network().calibration().State());
    SolveInsGnss(run);
    if (!adjustment_internal::ClockMayExplain(run.network(), before, run.result().cost)) break;
  }
}

}  // namespace dn
