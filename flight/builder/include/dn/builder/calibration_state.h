#pragma once

#include <dn/builder/calibration_effect.h>
#include <dn/flight/flight.h>
#include <dn/imu/preintegration.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace dn {

/// The value of one effect, SI.
struct CalibrationValue {
  std::string name;
  EffectAction action;
  Eigen::VectorXd value;
};

/// All calibration values of a flight: what filter, increments, factors and the trajectory between
/// the nodes correct the data with.
struct CalibrationState {
  Eigen::Quaterniond q_boresight = Eigen::Quaterniond::Identity();  ///< Exp(theta), left of T_bs
  Eigen::Vector3d gnss_lever_arm_b_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d lidar_lever_arm_b_m = Eigen::Vector3d::Zero();
  double lidar_time_offset_s = 0.0;
  std::vector<CalibrationValue> effects;  ///< in the order of EstimableEffects

  /// Adds an effect at a value, in its place.
  void Insert(CalibrationValue value);

  /// The correction of the raw inertial samples.
  ImuCorrection ImuAt(const Eigen::Vector3d& gyro_bias_radps,
                      const Eigen::Vector3d& accel_bias_mps2) const;

  /// Attraction beyond the normal one at p_m, m/s^2, map axes.
  Eigen::Vector3d AttractionAt(const Eigen::Vector3d& p_m) const;
};

/// Calls visit(action, value, index) for the effects that act in one way, in their order.
template <class Action, class Visit>
void ForEachEffect(const CalibrationState& state, const Visit& visit) {
  for (std::size_t k = 0; k < state.effects.size(); ++k) {
    const CalibrationValue& one = state.effects[k];
    if (const auto* action = std::get_if<Action>(&one.action)) visit(*action, one.value, k);
  }
}

/// Indices into CalibrationState::effects in the order in which the factors of one kind have them
/// as blocks, after their other blocks.
std::vector<std::size_t> EffectsOfInertial(
    const CalibrationState& state);  ///< inertial, attraction
std::vector<std::size_t> EffectsOfGnss(const CalibrationState& state);
std::vector<std::size_t> EffectsOfPairs(
    const CalibrationState& state);  ///< lidar, inertial, attraction

/// What the flight's configuration says, with the effects of `estimate` at zero. Throws
/// InvalidConfig for an effect that lacks its time.
CalibrationState AssumedCalibration(const Flight& flight);

/// The same of one unknown of `estimate` that is a vector, SI: corrections are counted from it.
Eigen::VectorXd AssumedValue(const Flight& flight, const std::string& unknown);

}  // namespace dn
