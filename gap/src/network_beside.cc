#include "network_beside.h"

#include <dn/builder/build.h>

#include <cstddef>
#include <map>

namespace dn::internal {
namespace {

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

}  // namespace

FlightNetwork NetworkBeside(const FlightNetwork& solved, const Flight& flight, int threads) {
  NetworkDesign design;
  design.node_t_s = solved.node_times();
  design.calibration = solved.Calibration();
  const auto nodes = static_cast<double>(design.node_t_s.size());
  for (std::size_t k = 0; k < design.node_t_s.size(); ++k) {
    design.poses.push_back(solved.NodePose(k));
    design.gyro_bias_radps += solved.GyroBias(design.node_t_s[k]) / nodes;
    design.accel_bias_mps2 += solved.AccelBias(design.node_t_s[k]) / nodes;
  }
  FlightNetwork network = Build(flight, design, {.threads = threads});
  KeepInUse(solved, &network);
  return network;
}

}  // namespace dn::internal
