#pragma once

#include <dn/builder/calibration_state.h>

#include <memory>
#include <vector>

namespace dn::builder_internal {

/// Returns the effects of a calibration on one sensor.
template <class Effect>
std::vector<std::shared_ptr<const Effect>> SharedEffects(const CalibrationState& state) {
  std::vector<std::shared_ptr<const Effect>> effects;
  ForEachEffect<std::shared_ptr<const Effect>>(
      state,
      [&](const auto& effect, const Eigen::VectorXd&, std::size_t) { effects.push_back(effect); });
  return effects;
}

/// Returns the values of these effects.
template <class Effect>
std::vector<const double*> EffectValues(const CalibrationState& state) {
  std::vector<const double*> values;
  ForEachEffect<std::shared_ptr<const Effect>>(
      state, [&](const auto&, const Eigen::VectorXd& value, std::size_t) {
        values.push_back(value.data());
      });
  return values;
}

/// Returns the correction of the inertial samples by these biases and the effects of a calibration.
inline ImuCorrection CorrectionWith(const CalibrationState& state, const ImuCorrection& biases) {
  return state.ImuAt(biases.gyro_bias_radps, biases.accel_bias_mps2);
}

}  // namespace dn::builder_internal
