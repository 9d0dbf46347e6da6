#include "changed_network.h"

#include <dn/builder/build.h>
#include <dn/builder/keep_in_use.h>

#include <cstddef>
#include <set>
#include <vector>

namespace dn::diagnosis_internal {
namespace {

constexpr double kShortestStepS = 0.45;

/// Returns the node times, without those that closely follow another one and have no GNSS epoch.
std::vector<double> SparseNodeTimes(const FlightNetwork& solved) {
  std::set<std::size_t> with_gnss;
  for (const GnssEdge& edge : solved.gnss().edges()) with_gnss.insert(edge.node);
  const std::vector<double>& all = solved.trajectory().node_times();
  std::vector<double> kept{all.front()};
  for (std::size_t k = 1; k < all.size(); ++k) {
    const bool last = k + 1 == all.size();
    if (last || with_gnss.count(k) > 0 || all[k] - kept.back() >= kShortestStepS) {
      kept.push_back(all[k]);
    }
  }
  return kept;
}

}  // namespace

FlightNetwork BuildChangedNetwork(const FlightNetwork& solved, const Flight& flight, int threads) {
  NetworkDesign design;
  design.node_t_s = SparseNodeTimes(solved);
  design.calibration = solved.calibration().State();
  const auto nodes = static_cast<double>(design.node_t_s.size());
  std::size_t node = 0;  // index in the solved network
  for (const double t_s : design.node_t_s) {
    while (solved.trajectory().node_times()[node] < t_s) ++node;
    design.poses.push_back(solved.trajectory().NodePose(node));
    design.gyro_bias_radps += solved.trajectory().GyroBias(t_s) / nodes;
    design.accel_bias_mps2 += solved.trajectory().AccelBias(t_s) / nodes;
  }
  FlightNetwork network = Build(flight, design, {.threads = threads});
  KeepInUse(solved, &network);
  return network;
}

}  // namespace dn::diagnosis_internal
