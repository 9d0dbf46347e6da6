#include <dn/builder/gnss_edges.h>
#include <dn/builder/node_grid.h>

#include <algorithm>
#include <cmath>

#include "append.h"
#include "factor_groups.h"

namespace dn {
namespace {

bool WithErrorsByBank(const EdgeContext& context) {
  if (!context.flight.gnss) return false;
  const std::vector<GnssProcess>& processes = context.flight.config.gnss->processes;
  return std::any_of(processes.begin(), processes.end(), [](const GnssProcess& process) {
    return process.growth == GnssErrorGrowth::kBank;
  });
}

}  // namespace

GnssEdges::GnssEdges(const EdgeContext& context) : context_(context) {
  if (!context_.flight.gnss) return;
  const CalibrationState calibration = context_.calibration.State();
  const std::vector<double>& node_t_s = context_.trajectory.node_times();
  const auto& epochs = context_.flight.gnss->epochs;
  for (std::size_t e = 0; e < epochs.size(); ++e) {
    const double t_s = GnssEpochTime(calibration, epochs[e].t_s);
    const std::size_t node = NodeBefore(node_t_s, t_s + 1e-6);
    const bool outside_span = std::abs(node_t_s[node] - t_s) > kOnNodeS;
    if (!outside_span) Add(e, node, calibration);
  }
}

void GnssEdges::Add(std::size_t epoch_index, std::size_t node,
                    const CalibrationState& calibration) {
  const MapGnssEpoch& epoch = context_.flight.gnss->epochs[epoch_index];
  const std::vector<ProcessChain>& errors = context_.trajectory.gnss_error();
  const std::vector<BlockId> effects =
      context_.calibration.EffectIds(GnssEffectIndices(calibration));
  const NodeBlocks& at = context_.trajectory.nodes()[node];
  const BlockId lever_arm = context_.calibration.gnss_lever_arm().id;
  const std::vector<BlockId> antenna{at.q_mb.id, at.p_mb.id, lever_arm, at.v_m.id};
  std::vector<BlockId> position{at.q_mb.id, at.p_mb.id, lever_arm};
  std::vector<BlockId> velocity{at.q_mb.id, at.v_m.id, lever_arm};
  if (!effects.empty() || !errors.empty()) {
    position = antenna;
    for (const ProcessChain& chain : errors) position.push_back(chain.At(epoch.t_s).id);
    builder_internal::Append(effects, &position);
  }
  if (!effects.empty()) {
    velocity = antenna;
    builder_internal::Append(effects, &velocity);
  }
  GnssEdge edge{node, epoch_index, -1, -1};
  edge.position = context_.factors.Add(PositionFactor(edge, calibration), position,
                                       builder_internal::GnssPositionGroup(), epoch.t_s);
  if (UsesVelocity(epoch, *context_.flight.config.gnss)) {
    edge.velocity = context_.factors.Add(VelocityFactor(edge, calibration), velocity,
                                         builder_internal::GnssVelocityGroup(), epoch.t_s);
  }
  edges_.push_back(edge);
}

const MapGnssEpoch& GnssEdges::Epoch(const GnssEdge& edge) const {
  return context_.flight.gnss->epochs[edge.epoch];
}

GnssEdgeInput GnssEdges::Input(const GnssEdge& edge) const {
  return {context_.trajectory.NodePose(edge.node), context_.trajectory.BiasesAt(Epoch(edge).t_s)};
}

std::shared_ptr<const FactorBase> GnssEdges::PositionFactor(
    const GnssEdge& edge, const CalibrationState& calibration) const {
  return MakeGnssPositionFactor(context_.flight, Epoch(edge), calibration, Input(edge));
}

std::shared_ptr<const FactorBase> GnssEdges::VelocityFactor(
    const GnssEdge& edge, const CalibrationState& calibration) const {
  return MakeGnssVelocityFactor(context_.flight, Epoch(edge), calibration, Input(edge));
}

void GnssEdges::Rebuild(const CalibrationState& calibration) {
  const bool by_motion = !GnssEffectIndices(calibration).empty() || WithErrorsByBank(context_);
  for (const GnssEdge& edge : edges_) {
    if (by_motion) {
      context_.factors.Renew(edge.position, [&] { return PositionFactor(edge, calibration); });
    }
    if (edge.velocity >= 0) {
      context_.factors.Renew(edge.velocity, [&] { return VelocityFactor(edge, calibration); });
    }
  }
}

}  // namespace dn
