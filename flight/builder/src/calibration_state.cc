#include <dn/builder/beam_unknowns.h>
#include <dn/builder/calibration_state.h>
#include <dn/effects/effect_table.h>
#include <dn/files/scanners.h>
#include <dn/rotation.h>

#include <algorithm>

namespace dn {
namespace {

/// Returns the place of an effect in the order of corrections; user-defined effects come last.
std::size_t Rank(const std::string& name) {
  const std::vector<EstimableEffect>& all = EstimableEffects();
  const EstimableEffect* effect = FindEstimable(name);
  return effect == nullptr ? all.size() : static_cast<std::size_t>(effect - all.data());
}

template <class Action>
void Append(const CalibrationState& state, std::vector<std::size_t>* indices) {
  ForEachEffect<Action>(
      state, [&](const Action&, const Eigen::VectorXd&, std::size_t k) { indices->push_back(k); });
}

}  // namespace

MountingState CalibrationState::MountingAt(std::size_t k) const {
  if (k > 0) return more_scanners[k - 1];
  return {q_boresight, lidar_lever_arm_b_m, lidar_time_offset_s};
}

void CalibrationState::Insert(CalibrationValue value) {
  const auto at = std::upper_bound(
      effects.begin(), effects.end(), Rank(value.name),
      [](std::size_t rank, const CalibrationValue& other) { return rank < Rank(other.name); });
  effects.insert(at, std::move(value));
}

ImuCorrection CalibrationState::ImuAt(const Eigen::Vector3d& gyro_bias_radps,
                                      const Eigen::Vector3d& accel_bias_mps2) const {
  std::vector<ImuEffectValue> values;
  ForEachEffect<std::shared_ptr<const ImuEffect>>(
      *this, [&](const auto& effect, const Eigen::VectorXd& value, std::size_t) {
        values.push_back({effect, value});
      });
  return {gyro_bias_radps, accel_bias_mps2, std::move(values)};
}

Eigen::Vector3d CalibrationState::GravitationAt(const Eigen::Vector3d& p_m) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  ForEachEffect<GravitationField>(
      *this, [&](const GravitationField& field, const Eigen::VectorXd& value, std::size_t) {
        sum += field(p_m) * value;
      });
  return sum;
}

std::vector<std::size_t> InertialEffectIndices(const CalibrationState& state) {
  std::vector<std::size_t> indices;
  Append<std::shared_ptr<const ImuEffect>>(state, &indices);
  Append<GravitationField>(state, &indices);
  return indices;
}

std::vector<std::size_t> GnssEffectIndices(const CalibrationState& state) {
  std::vector<std::size_t> indices;
  Append<std::shared_ptr<const GnssEffect>>(state, &indices);
  return indices;
}

std::vector<std::size_t> PairEffectIndices(const CalibrationState& state) {
  std::vector<std::size_t> indices;
  Append<std::shared_ptr<const LidarEffect>>(state, &indices);
  Append<std::shared_ptr<const ImuEffect>>(state, &indices);
  Append<GravitationField>(state, &indices);
  return indices;
}

CalibrationState AssumedCalibration(const Flight& flight) {
  const FlightConfig& config = flight.config;
  CalibrationState state;
  if (config.gnss) state.gnss_lever_arm_b_m = config.gnss->lever_arm_b_m;
  if (config.lidar) {
    state.q_boresight = Exp(config.lidar->mounting.boresight_rad);
    state.lidar_lever_arm_b_m = config.lidar->mounting.lever_arm_b_m;
  }
  for (const LidarConfig& lidar : config.more_scanners) {
    state.more_scanners.push_back(
        {Exp(lidar.mounting.boresight_rad), lidar.mounting.lever_arm_b_m, 0.0});
  }
  for (const EstimateEntry& entry : config.estimate) {
    const EstimableEffect* effect = FindEstimable(entry.unknown);
    if (effect == nullptr || effect->configured != nullptr) continue;
    const auto size = static_cast<Eigen::Index>(FindEffect(entry.unknown)->components.size());
    state.Insert({entry.unknown,
                  MakeAction(*effect, {flight, entry.times, FindScanner(config, entry.unknown)}),
                  Eigen::VectorXd::Zero(size)});
  }
  for (const BeamUnknown& unknown : FindBeamUnknowns(flight)) {
    state.Insert({unknown.name, BeamAction(flight, unknown),
                  Eigen::VectorXd::Zero(static_cast<Eigen::Index>(unknown.num_beams()))});
  }
  return state;
}

Eigen::VectorXd AssumedValue(const Flight& flight, const std::string& unknown) {
  const EstimableEffect* effect = FindEstimable(unknown);
  if (effect != nullptr && effect->configured != nullptr) {
    return effect->configured(flight.config, FindScanner(flight.config, unknown));
  }
  return Eigen::VectorXd::Zero(static_cast<Eigen::Index>(FindEffect(unknown)->components.size()));
}

}  // namespace dn
