#include <dn/axis_names.h>
#include <dn/builder/beam_unknowns.h>
#include <dn/builder/calibration_blocks.h>
#include <dn/effects/effect_table.h>
#include <dn/error.h>
#include <dn/factors/prior.h>
#include <dn/files/scanners.h>
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
      if (IsBeamUnknown(name)) {
        return net->AddBlock(name, VectorKind(static_cast<int>(value.size())), value);
      }
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

BlockLabel BeamLabel(const std::string& name, Eigen::Index size) {
  std::vector<std::string> components;
  for (Eigen::Index k = 0; k < size; ++k) components.push_back("beam " + std::to_string(k));
  const bool angle = name.find("angle") < name.find('/');
  return {angle ? "beam angle" : "beam range offset", components, angle ? "deg" : "m",
          angle ? kDegPerRad : 1.0};
}

/// Returns the label of an effect of the effect table, or a plain label for a user-defined effect.
BlockLabel EffectLabel(const std::string& name, Eigen::Index size) {
  if (IsBeamUnknown(name)) return BeamLabel(name, size);
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
  AddScanner(0, initial.MountingAt(0));
  AddGnssLeverArm(initial);
  for (std::size_t k = 1; k < NumScanners(flight.config); ++k) {
    AddScanner(k, initial.MountingAt(k));
  }
  AddEffects(initial);
  AddPriors();
  AddBeamPriors();
}

bool CalibrationBlocks::IsEstimated(const std::string& unknown) const {
  const auto& estimate = flight_.config.estimate;
  return std::any_of(estimate.begin(), estimate.end(),
                     [&](const EstimateEntry& entry) { return entry.unknown == unknown; });
}

void CalibrationBlocks::AddGnssLeverArm(const CalibrationState& initial) {
  const std::string& name = EffectName(EffectId::kGnssLeverArm);
  gnss_lever_arm_ = net_.AddVector<3>(name, initial.gnss_lever_arm_b_m);
  net_.SetLabel(gnss_lever_arm_.id, {"GNSS lever arm", AxisNames(kXyz), "m", 1.0});
  net_.Hold(gnss_lever_arm_, !IsEstimated(name));
}

void CalibrationBlocks::AddScanner(std::size_t k, const MountingState& initial) {
  const auto name = [&](const std::string& unknown) {
    return ScannerName(flight_.config, unknown, k);
  };
  const std::string of_scanner = k == 0 ? "" : " of " + ScannerAt(flight_.config, k).name;
  const std::string boresight = name("boresight");
  const std::string lever_arm = name(EffectName(EffectId::kLidarLeverArm));
  const std::string time_offset = name(EffectName(EffectId::kLidarTimeOffset));
  ScannerBlocks blocks;
  blocks.boresight = net_.AddLeftRotation(boresight, initial.q_boresight);
  blocks.lever_arm = net_.AddVector<3>(lever_arm, initial.lever_arm_b_m);
  blocks.time_offset =
      net_.AddVector<1>(time_offset, Eigen::Matrix<double, 1, 1>(initial.time_offset_s));
  net_.SetLabel(blocks.boresight.id,
                {"boresight" + of_scanner, AxisNames(kRollPitchYaw), "deg", kDegPerRad});
  net_.SetLabel(blocks.lever_arm.id, {"lidar lever arm" + of_scanner, AxisNames(kXyz), "m", 1.0});
  net_.SetLabel(blocks.time_offset.id, {"lidar time offset" + of_scanner, {"t"}, "s", 1.0});
  net_.Hold(blocks.boresight, !flight_.config.lidar || !IsEstimated(boresight));
  net_.Hold(blocks.lever_arm, !IsEstimated(lever_arm));
  net_.Hold(blocks.time_offset, !IsEstimated(time_offset));
  scanners_.push_back(blocks);
}

void CalibrationBlocks::AddEffects(const CalibrationState& initial) {
  for (const CalibrationValue& one : initial.effects) {
    const BlockId id = AddVectorBlock(one.name, one.value, &net_);
    net_.SetLabel(id, EffectLabel(one.name, one.value.size()));
    net_.Hold(id, !IsEstimated(one.name) && !IsBeamUnknown(one.name));
    effects_.push_back({one.name, one.action, id});
  }
}

void CalibrationBlocks::AddBoresightPrior(std::size_t k) {
  const LidarConfig& lidar = ScannerAt(flight_.config, k);
  if (!lidar.boresight_sigma_rad) return;
  const FactorId id = net_.Add(PriorLeftRotation(Exp(lidar.mounting.boresight_rad),
                                                 Noise<3>::Sigma(*lidar.boresight_sigma_rad)),
                               scanners_[k].boresight);
  net_.Tag(id, builder_internal::PriorGroup(), std::numeric_limits<double>::quiet_NaN());
}

void CalibrationBlocks::AddPriors() {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const FlightConfig& config = flight_.config;
  for (std::size_t k = 0; k < NumScanners(config); ++k) AddBoresightPrior(k);
  for (const EstimateEntry& entry : config.estimate) {
    if (entry.sigma.empty()) continue;
    const BlockId block = net_.Find(entry.unknown);
    net_.Tag(AddPrior(block, AssumedValue(flight_, entry.unknown), *PriorSigma(entry), &net_),
             builder_internal::PriorGroup(), nan);
  }
}

void CalibrationBlocks::AddBeamPriors() {
  for (const BeamUnknown& unknown : FindBeamUnknowns(flight_)) {
    const auto has_name = [&](const EffectBlock& effect) { return effect.name == unknown.name; };
    const auto effect = std::find_if(effects_.begin(), effects_.end(), has_name);
    if (effect == effects_.end()) continue;
    const FactorId id =
        net_.AddFactor(std::make_shared<LinearPrior>(BeamPrior(unknown)), {effect->id});
    net_.Tag(id, builder_internal::PriorGroup(), std::numeric_limits<double>::quiet_NaN());
  }
}

CalibrationState CalibrationBlocks::State() const {
  CalibrationState state;
  state.gnss_lever_arm_b_m = net_.Value(gnss_lever_arm_);
  for (std::size_t k = 0; k < scanners_.size(); ++k) {
    const MountingState mounting{net_.Value(scanners_[k].boresight),
                                 net_.Value(scanners_[k].lever_arm),
                                 net_.Value(scanners_[k].time_offset)[0]};
    if (k > 0) {
      state.more_scanners.push_back(mounting);
      continue;
    }
    state.q_boresight = mounting.q_boresight;
    state.lidar_lever_arm_b_m = mounting.lever_arm_b_m;
    state.lidar_time_offset_s = mounting.time_offset_s;
  }
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
  const auto is_free = [&](const ScannerBlocks& scanner) {
    return !net_.block(scanner.time_offset.id).held;
  };
  return std::any_of(scanners_.begin(), scanners_.end(), is_free) ||
         std::any_of(effects_.begin(), effects_.end(), moves);
}

}  // namespace dn
