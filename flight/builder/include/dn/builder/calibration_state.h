#pragma once

#include <dn/builder/calibration_effect.h>
#include <dn/files/flight.h>
#include <dn/imu/preintegration.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace dn {

/// The value of one effect in SI units.
struct CalibrationValue {
  std::string name;
  EffectAction action;
  Eigen::VectorXd value;
};

/// The values of the mounting of one scanner.
struct MountingState {
  /// Exp(theta), multiplies R_bs_nominal from the left
  Eigen::Quaterniond q_boresight = Eigen::Quaterniond::Identity();
  Eigen::Vector3d lever_arm_b_m = Eigen::Vector3d::Zero();
  double time_offset_s = 0.0;
};

/// All calibration values of a flight. The filter, the preintegrated increments, the factors and
/// the trajectory between the nodes correct the data with them.
struct CalibrationState {
  /// Exp(theta) of the first scanner, multiplies R_bs_nominal from the left
  Eigen::Quaterniond q_boresight = Eigen::Quaterniond::Identity();
  Eigen::Vector3d gnss_lever_arm_b_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d lidar_lever_arm_b_m = Eigen::Vector3d::Zero();
  double lidar_time_offset_s = 0.0;
  std::vector<MountingState> more_scanners;  ///< the mountings of the other scanners
  std::vector<CalibrationValue> effects;     ///< in the order of EstimableEffects

  /// Returns the mounting of scanner k.
  MountingState MountingAt(std::size_t k) const;

  /// Inserts an effect with its value at its place in the order of EstimableEffects; user-defined
  /// effects come last.
  void Insert(CalibrationValue value);

  /// Returns the correction of the raw inertial samples: these biases and the effects on the IMU.
  ImuCorrection ImuAt(const Eigen::Vector3d& gyro_bias_radps,
                      const Eigen::Vector3d& accel_bias_mps2) const;

  /// Returns the gravitation that the effects add to normal gravity at p_m, m/s^2, map axes.
  Eigen::Vector3d GravitationAt(const Eigen::Vector3d& p_m) const;
};

/// Calls visit(action, value, index) for every effect whose action has the type `Action`, in the
/// order of `effects`.
template <class Action, class Visit>
void ForEachEffect(const CalibrationState& state, const Visit& visit) {
  for (std::size_t k = 0; k < state.effects.size(); ++k) {
    const CalibrationValue& one = state.effects[k];
    if (const auto* action = std::get_if<Action>(&one.action)) visit(*action, one.value, k);
  }
}

/// These functions return indices into CalibrationState::effects of the effects that act on one
/// kind of factor. The order is that of the blocks of the factor; these blocks come after its other
/// blocks.
std::vector<std::size_t> InertialEffectIndices(
    const CalibrationState& state);  ///< effects on the IMU, then on gravitation
std::vector<std::size_t> GnssEffectIndices(const CalibrationState& state);
std::vector<std::size_t> PairEffectIndices(
    const CalibrationState& state);  ///< effects on the lidar, the IMU, then on gravitation

/// Returns the calibration of the configuration, with the effects of `estimate` at zero. Throws
/// InvalidConfig for an effect that lacks its time.
CalibrationState AssumedCalibration(const Flight& flight);

/// Returns the configured value of one vector unknown of `estimate`, SI. Reports give its
/// correction relative to this value.
Eigen::VectorXd AssumedValue(const Flight& flight, const std::string& unknown);

}  // namespace dn
