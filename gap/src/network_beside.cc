#include "network_beside.h"

#include <dn/builder/build.h>

#include <cstddef>
#include <map>
#include <set>
#include <vector>

namespace dn::internal {
namespace {

constexpr double kShortestStepS = 0.45;

void KeepInUse(const FlightNetwork& solved, FlightNetwork* network) {
  std::map<std::size_t, const FlightNetwork::GnssEdge*> of_epoch;
  for (const FlightNetwork::GnssEdge& edge : solved.gnss_edges) of_epoch[edge.epoch] = &edge;
  const auto keep = [&](FactorId before, FactorId now) {
    const bool in_use = before >= 0 && solved.net.factor(before).active;
    if (now >= 0) network->net.SetActive(now, in_use);
  };
  for (const FlightNetwork::GnssEdge& edge : network->gnss_edges) {
    const auto found = of_epoch.find(edge.epoch);
    keep(found == of_epoch.end() ? -1 : found->second->position, edge.position);
    keep(found == of_epoch.end() ? -1 : found->second->velocity, edge.velocity);
  }
  for (std::size_t k = 0; k < network->pair_edges.size(); ++k) {
    keep(k < solved.pair_edges.size() ? solved.pair_edges[k].id : -1, network->pair_edges[k].id);
  }
}

/// Node times without those that follow another too closely and have no GNSS epoch.
std::vector<double> Thinned(const FlightNetwork& solved) {
  std::set<std::size_t> with_gnss;
  for (const FlightNetwork::GnssEdge& edge : solved.gnss_edges) with_gnss.insert(edge.node);
  const std::vector<double>& all = solved.node_times();
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

FlightNetwork NetworkBeside(const FlightNetwork& solved, const Flight& flight, int threads) {
  NetworkDesign design;
  design.node_t_s = Thinned(solved);
  design.calibration = solved.Calibration();
  const auto nodes = static_cast<double>(design.node_t_s.size());
  std::size_t node = 0;  // of the solved network
  for (const double t_s : design.node_t_s) {
    while (solved.node_times()[node] < t_s) ++node;
    design.poses.push_back(solved.NodePose(node));
    design.gyro_bias_radps += solved.GyroBias(t_s) / nodes;
    design.accel_bias_mps2 += solved.AccelBias(t_s) / nodes;
  }
  FlightNetwork network = Build(flight, design, {.threads = threads});
  KeepInUse(solved, &network);
  return network;
}

}  // namespace dn::internal
