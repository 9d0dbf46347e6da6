#include <dn/axis_names.h>
#include <dn/builder/calibration_blocks.h>
#include <dn/effects/effect_table.h>
#include <dn/error.h>
#include <dn/factors/prior.h>
#include <dn/rotation.h>

#include <algorithm>
#include <limits>

#include "factor_groups.h"

namespace dn {
namespace {

BlockId AddVectorBlock(const std::string& name, const Eigen::VectorXd& value, Network* net) {
  switch (value.size()) {
    case 1:
      return net->AddVector<1>(name, value).id;
    case 2:
      return net->AddVector<2>(name, value).id;
    case 3:
      return net->AddVector<3>(name, value).id;
    default:
      throw InvalidInput("effect '" + name + "' has " + std::to_string(value.size()) +
                         " values, but only effects with one to three values can be estimated");
  }
}

template <int N>
FactorId AddSizedPrior(BlockId block, const Eigen::VectorXd& center, const Eigen::VectorXd& sigma,
                       Network* net) {
  const Eigen::Matrix<double, N, 1> sigmas = sigma;
  return net->Add(PriorVector<N>(center, Noise<N>::Sigma(sigmas)), Block<Vec<N>>{block});
}

FactorId AddPrior(BlockId block, const Eigen::VectorXd& center, const Eigen::VectorXd& sigma,
                  Network* net) {
  if (center.size() == 1) return AddSizedPrior<1>(block, center, sigma, net);
  if (center.size() == 2) return AddSizedPrior<2>(block, center, sigma, net);
  return AddSizedPrior<3>(block, center, sigma, net);
}

/// Returns the label of an effect of the effect table, or a plain label for a user-defined effect.
BlockLabel EffectLabel(const std::string& name, Eigen::Index size) {
  const EffectSpec* spec = FindEffect(name);
  const EstimableEffect* effect = FindEstimable(name);
  if (spec == nullptr || effect == nullptr) return {name, {}, "", 1.0};
  std::vector<std::string> components;
  for (const EffectComponent& one : spec->components) components.push_back(one.name);
  components.resize(static_cast<std::size_t>(size));
  return {effect->quantity, components, spec->components[0].unit, 1.0 / spec->components[0].to_si};
}

}  // namespace

CalibrationBlocks::CalibrationBlocks(const Flight& flight, const CalibrationState& initial,
                                     Network* net)
    : flight_(flight), net_(*net) {
  AddMounting(initial);
  AddEffects(initial);
  AddPriors();
}

bool CalibrationBlocks::IsEstimated(const std::string& unknown) const {
  const auto& estimate = flight_.config.estimate;
  return std::any_of(estimate.begin(), estimate.end(),
                     [&](const EstimateEntry& entry) { return entry.unknown == unknown; });
}

void CalibrationBlocks::AddMounting(const CalibrationState& initial) {
  boresight_ = net_.AddLeftRotation("boresight", initial.q_boresight);
  gnss_lever_arm_ =
      net_.AddVector<3>(EffectName(EffectId::kGnssLeverArm), initial.gnss_lever_arm_b_m);
  lidar_lever_arm_ =
      net_.AddVector<3>(EffectName(EffectId::kLidarLeverArm), initial.lidar_lever_arm_b_m);
  lidar_time_offset_ = net_.AddVector<1>(EffectName(EffectId::kLidarTimeOffset),
                                         Eigen::Matrix<double, 1, 1>(initial.lidar_time_offset_s));
  net_.SetLabel(boresight_.id, {"boresight", AxisNames(kRollPitchYaw), "deg", kDegPerRad});
  net_.SetLabel(gnss_lever_arm_.id, {"GNSS lever arm", AxisNames(kXyz), "m", 1.0});
  net_.SetLabel(lidar_lever_arm_.id, {"lidar lever arm", AxisNames(kXyz), "m", 1.0});
  net_.SetLabel(lidar_time_offset_.id, {"lidar time offset", {"t"}, "s", 1.0});
  net_.Hold(boresight_, !flight_.config.lidar || !IsEstimated("boresight"));
  net_.Hold(gnss_lever_arm_, !IsEstimated(EffectName(EffectId::kGnssLeverArm)));
  net_.Hold(lidar_lever_arm_, !IsEstimated(EffectName(EffectId::kLidarLeverArm)));
  net_.Hold(lidar_time_offset_, !IsEstimated(EffectName(EffectId::kLidarTimeOffset)));
}

void CalibrationBlocks::AddEffects(const CalibrationState& initial) {
  for (const CalibrationValue& one : initial.effects) {
    const BlockId id = AddVectorBlock(one.name, one.value, &net_);
    net_.SetLabel(id, EffectLabel(one.name, one.value.size()));
    net_.Hold(id, !IsEstimated(one.name));
    effects_.push_back({one.name, one.action, id});
  }
}

void CalibrationBlocks::AddPriors() {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const FlightConfig& config = flight_.config;
  if (config.lidar && config.lidar->boresight_sigma_rad) {
    const FactorId id =
        net_.Add(PriorLeftRotation(Exp(config.lidar->mounting.boresight_rad),
                                   Noise<3>::Sigma(*config.lidar->boresight_sigma_rad)),
                 boresight_);
    net_.Tag(id, builder_internal::PriorGroup(), nan);
  }
  for (const EstimateEntry& entry : config.estimate) {
    if (entry.unknown == "boresight" || entry.sigma.empty()) continue;
    const BlockId block = net_.Find(entry.unknown);
    net_.Tag(AddPrior(block, AssumedValue(flight_, entry.unknown), *PriorSigma(entry), &net_),
             builder_internal::PriorGroup(), nan);
  }
}

CalibrationState CalibrationBlocks::State() const {
  CalibrationState state;
  state.q_boresight = net_.Value(boresight_);
  state.gnss_lever_arm_b_m = net_.Value(gnss_lever_arm_);
  state.lidar_lever_arm_b_m = net_.Value(lidar_lever_arm_);
  state.lidar_time_offset_s = net_.Value(lidar_time_offset_)[0];
  for (const EffectBlock& effect : effects_) {
    const BlockRecord& block = net_.block(effect.id);
    state.effects.push_back(
        {effect.name, effect.action,
         Eigen::Map<const Eigen::VectorXd>(block.value.get(), block.kind.stored_size)});
  }
  return state;
}

std::vector<BlockId> CalibrationBlocks::EffectIds(const std::vector<std::size_t>& indices) const {
  std::vector<BlockId> ids;
  for (const std::size_t k : indices) ids.push_back(effects_[k].id);
  return ids;
}

bool CalibrationBlocks::MovesLidarEpochs() const {
  const auto moves = [](const EffectBlock& effect) {
    const auto* lidar = std::get_if<std::shared_ptr<const LidarEffect>>(&effect.action);
    return lidar != nullptr && (*lidar)->moves_epochs();
  };
  return !net_.block(lidar_time_offset_.id).held ||
         std::any_of(effects_.begin(), effects_.end(), moves);
}

}  // namespace dn
