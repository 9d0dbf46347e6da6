#include <dn/builder/gravitation_jacobians.h>
#include <dn/builder/inertial_edges.h>
#include <dn/effects/effect_table.h>
#include <dn/parallel.h>

#include <algorithm>
#include <cmath>

#include "append.h"
#include "effect_values.h"
#include "factor_groups.h"

namespace dn {
namespace {

// Units of BiasChange: a bias change of one unit makes the first-order correction of an increment
// inaccurate.
constexpr double kGyroStepRadps = 30.0 / kDegPerRad / 3600.0;
constexpr double kAccelStepMps2 = 5e-3 * kStandardGravityMps2;
// The same unit for an effect, as a multiple of its typical sizes.
constexpr double kEffectStep = 10.0;

/// Returns the largest component of a change in typical sizes of the effect; for a user-defined
/// effect in units of its value.
double InTypicalSizes(const CalibrationValue& before, const Eigen::VectorXd& now) {
  const EffectSpec* spec = FindEffect(before.name);
  double largest = 0.0;
  for (Eigen::Index k = 0; k < now.size(); ++k) {
    const double usual =
        spec == nullptr ? 1.0 : spec->components[static_cast<std::size_t>(k)].typical_si();
    largest = std::max(largest, std::abs(now[k] - before.value[k]) / usual);
  }
  return largest;
}

}  // namespace

InertialEdges::InertialEdges(const EdgeContext& context) : context_(context) {
  const TrajectoryGraph& trajectory = context_.trajectory;
  const std::vector<double>& node_t_s = trajectory.node_times();
  for (std::size_t i = 0; i + 1 < node_t_s.size(); ++i) {
    if (!HasGap(*context_.flight.imu, node_t_s[i], node_t_s[i + 1])) edges_.push_back({i, -1});
  }
  SetLinearisation(context_.calibration.State());
  const auto factors = Factors();
  const std::vector<BlockId> effects =
      context_.calibration.EffectIds(InertialEffectIndices(linearised_));
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    const std::size_t i = edges_[e].node_i;
    std::vector<BlockId> blocks = trajectory.NodeIds(i);
    builder_internal::Append(trajectory.NodeIds(i + 1), &blocks);
    builder_internal::Append(trajectory.BiasIds(i), &blocks);
    builder_internal::Append(effects, &blocks);
    edges_[e].id =
        context_.factors.Add(factors[e], blocks, builder_internal::InertialGroup(), node_t_s[i]);
  }
}

std::optional<std::size_t> InertialEdges::FindEdge(std::size_t node) const {
  const auto at =
      std::lower_bound(edges_.begin(), edges_.end(), node,
                       [](const InertialEdge& edge, std::size_t k) { return edge.node_i < k; });
  if (at == edges_.end() || at->node_i != node) return std::nullopt;
  return static_cast<std::size_t>(at - edges_.begin());
}

void InertialEdges::SetLinearisation(const CalibrationState& calibration) {
  linearised_ = calibration;
  linearised_biases_.clear();
  for (const InertialEdge& edge : edges_) {
    const double t_s = context_.trajectory.node_times()[edge.node_i];
    linearised_biases_.push_back(context_.trajectory.BiasesAt(t_s));
  }
}

std::shared_ptr<const PreintegratedInertial> InertialEdges::FactorOn(
    const Preintegrated& increments, const InertialEdge& edge,
    const CalibrationState& calibration) const {
  const TrajectoryGraph& trajectory = context_.trajectory;
  const Eigen::Vector3d p_i = trajectory.NodePose(edge.node_i).p_mb;
  return std::make_shared<PreintegratedInertial>(
      increments, context_.flight.frame, p_i, trajectory.NodePose(edge.node_i + 1).p_mb,
      static_cast<int>(trajectory.gyro_bias().size()),
      static_cast<int>(trajectory.accel_bias().size()), GravitationJacobians(calibration, p_i));
}

std::shared_ptr<const PreintegratedInertial> InertialEdges::Factor(
    const InertialEdge& edge, const CalibrationState& calibration) const {
  const std::vector<double>& node_t_s = context_.trajectory.node_times();
  const double t_s = node_t_s[edge.node_i];
  const Preintegrated increments =
      Preintegrate(*context_.flight.imu, t_s, node_t_s[edge.node_i + 1],
                   builder_internal::CorrectionWith(calibration, context_.trajectory.BiasesAt(t_s)),
                   context_.noise);
  return FactorOn(increments, edge, calibration);
}

std::shared_ptr<const PreintegratedInertial> InertialEdges::FactorByMeans(
    const InertialEdge& edge, const CalibrationState& calibration, const ImuData& imu) const {
  Preintegrated increments = FactorInUse(edge)->increments();
  const ImuCorrection correction =
      builder_internal::CorrectionWith(calibration, increments.linearisation);
  if (!correction.effects.empty()) {
    increments.J_effects =
        Preintegrate(imu, increments.t_begin_s, increments.t_end_s, correction, {}).J_effects;
  }
  increments.linearisation = correction;
  return FactorOn(increments, edge, calibration);
}

std::shared_ptr<const PreintegratedInertial> InertialEdges::FactorInUse(
    const InertialEdge& edge) const {
  auto in_use =
      std::dynamic_pointer_cast<const PreintegratedInertial>(context_.net.factor(edge.id).factor);
  return in_use ? in_use : Factor(edge, linearised_);
}

std::vector<std::shared_ptr<const PreintegratedInertial>> InertialEdges::Factors() const {
  std::vector<std::shared_ptr<const PreintegratedInertial>> factors(edges_.size());
  ParallelFor(static_cast<int>(factors.size()), context_.threads, [&](int e) {
    const auto k = static_cast<std::size_t>(e);
    factors[k] = Factor(edges_[k], linearised_);
  });
  return factors;
}

void InertialEdges::Repreintegrate(const CalibrationState& calibration) {
  SetLinearisation(calibration);
  const auto factors = Factors();
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    context_.factors.Renew(edges_[e].id, [&] { return factors[e]; });
  }
}

double InertialEdges::BiasChange() const {
  double change = 0.0;
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    const ImuCorrection& before = linearised_biases_[e];
    const ImuCorrection now =
        context_.trajectory.BiasesAt(context_.trajectory.node_times()[edges_[e].node_i]);
    const Eigen::Vector3d gyro = now.gyro_bias_radps - before.gyro_bias_radps;
    const Eigen::Vector3d accel = now.accel_bias_mps2 - before.accel_bias_mps2;
    change = std::max({change, gyro.cwiseAbs().maxCoeff() / kGyroStepRadps,
                       accel.cwiseAbs().maxCoeff() / kAccelStepMps2});
  }
  const CalibrationState now = context_.calibration.State();
  for (std::size_t k = 0; k < now.effects.size(); ++k) {
    change = std::max(change,
                      InTypicalSizes(linearised_.effects[k], now.effects[k].value) / kEffectStep);
  }
  return change;
}

}  // namespace dn
