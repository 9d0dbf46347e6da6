#include <dn/factors/point_to_point.h>

#include "candidate_effects.h"
#include "lidar_effects.h"

namespace dn::internal {
namespace {

PairEnd MakeEnd(const FlightNetwork& network, const PointToPoint::EndDerivatives& derivatives,
                double t_s, const Eigen::Vector3d& u_s) {
  PairEnd end =
      MakePairEnd(*network.flight().config.lidar, network.net.Value(network.boresight), t_s, u_s);
  end.J_r_u = derivatives.J_r_u;
  end.J_r_t = derivatives.J_r_t;
  return end;
}

std::vector<PairEnds> ActivePairs(const FlightNetwork& network) {
  std::vector<PairEnds> pairs;
  for (const FlightNetwork::PairEdge& edge : network.pair_edges) {
    if (!network.net.factor(edge.id).active) continue;
    const auto& factor = static_cast<const PointToPoint&>(*network.net.factor(edge.id).factor);
    const auto [i, j] = factor.DerivativesOfEnds(ValuesOf(network.net, edge.id).data());
    pairs.push_back({edge.id, MakeEnd(network, i, edge.pair.t_i_s, edge.pair.u_i_s),
                     MakeEnd(network, j, edge.pair.t_j_s, edge.pair.u_j_s)});
  }
  return pairs;
}

}  // namespace

void AddLidarCandidates(const FlightNetwork& network, std::vector<CandidateEffect>* effects) {
  if (network.pair_edges.empty()) return;
  const std::vector<PairEnds> pairs = ActivePairs(network);
  if (network.net.block(network.lidar_time_offset.id).held) {
    effects->push_back(
        TimeOffset("check the time tags of the pair files against those of imu.file, or estimate "
                   "lidar_time_offset",
                   TimeOffsetModel(pairs)));
  }
  if (network.net.block(network.lidar_lever_arm.id).held) {
    effects->push_back(
        LeverArm("check the sign, axes and unit of lidar.lever_arm_m, or estimate lidar_lever_arm",
                 LeverArmModel(pairs)));
  }
  AddEffectsOfScanner(pairs, effects);
  AddMovesOfMount(pairs, FindStrips(network.flight()), effects);
}

}  // namespace dn::internal
