#include <dn/imu/strapdown.h>
#include <dn/rotation.h>

#include <algorithm>

#include "candidate_effects.h"

namespace dn::internal {
namespace {

using Eigen::Vector3d;

/// Velocity and acceleration of the antenna with respect to the Earth, map axes.
struct AntennaMotion {
  Vector3d v_m, a_m;
};

AntennaMotion MotionAt(const FlightNetwork& network, std::size_t node) {
  const MapPose pose = network.NodePose(node);
  const ImuCorrection biases{network.GyroBias(pose.t_s), network.AccelBias(pose.t_s)};
  const Preintegrated here = IdentityIncrement(*network.flight().imu, pose.t_s, biases);
  const Vector3d w_eb_b =
      here.w_end_b_radps - pose.q_mb.conjugate() * network.flight().frame.w_ie_m();
  const Vector3d lever_b = network.net.Value(network.gnss_lever_arm);
  const std::size_t before = node > 0 ? node - 1 : node;
  const std::size_t after = std::min(node + 1, network.nodes.size() - 1);
  const double dt_s = network.node_times()[after] - network.node_times()[before];
  return {pose.v_m + pose.q_mb * w_eb_b.cross(lever_b),
          (network.NodePose(after).v_m - network.NodePose(before).v_m) / dt_s};
}

/// A tag that is late by dt belongs to the position and the velocity of dt before.
EffectModel LateTags(const FlightNetwork& network) {
  constexpr std::size_t kMeasuredBlock = 1;  // position or velocity of the node
  EffectModel model;
  for (const FlightNetwork::GnssEdge& edge : network.gnss_edges) {
    const AntennaMotion motion = MotionAt(network, edge.node);
    const auto add = [&](FactorId id, const Vector3d& rate) {
      Eigen::VectorXd r;
      std::vector<Eigen::MatrixXd> J;
      if (id < 0 || !network.net.factor(id).active || !network.net.EvaluateFactor(id, &r, &J)) {
        return;
      }
      model.push_back({id, Eigen::MatrixXd(-J[kMeasuredBlock] * rate)});
    };
    add(edge.position, motion.v_m);
    add(edge.velocity, motion.a_m);
  }
  return model;
}

}  // namespace

void AddGnssCandidates(const FlightNetwork& network, std::vector<CandidateEffect>* effects) {
  if (network.gnss_edges.empty()) return;
  std::vector<FactorId> factors;
  for (const FlightNetwork::GnssEdge& edge : network.gnss_edges) {
    factors.push_back(edge.position);
    if (edge.velocity >= 0) factors.push_back(edge.velocity);
  }
  effects->push_back({"gnss_lever_arm", "m", 1.0, Vector3d::Constant(0.03),
                      "check the sign, axes and unit of gnss.lever_arm_m, or estimate "
                      "gnss_lever_arm",
                      ModelOfBlock(network.net, factors, network.gnss_lever_arm.id)});
  effects->push_back({"gnss_time_offset", "s", 1.0, Eigen::VectorXd::Constant(1, 1e-3),
                      "check the time system of gnss.file against that of imu.file and correct "
                      "its time tags",
                      LateTags(network)});
}

}  // namespace dn::internal
