#include <dn/builder/gravitation_jacobians.h>
#include <dn/builder/measurement_noise.h>
#include <dn/builder/pair_factors.h>
#include <dn/error.h>
#include <dn/factors/point_to_point.h>
#include <dn/factors/point_to_point_between_nodes.h>
#include <dn/rotation.h>

#include <algorithm>
#include <string>
#include <utility>

#include "effect_values.h"

namespace dn {
namespace {

constexpr const char* kCheckPair =
    "check its laser vectors and covariance, and the white noise of the IMU";
constexpr double kEpochRoundingS = 1e-7;

/// Returns lever arm plus laser vector of a reading, body axes, m.
Eigen::Vector3d ArmToPoint(const Mounting& mounting, const CalibrationState& state,
                           const LidarReading& reading) {
  const Eigen::Quaterniond q_boresight =
      reading.turn_b_rad.isZero(0.0)
          ? state.q_boresight
          : Exp(Eigen::Vector3d(Log(state.q_boresight) + reading.turn_b_rad));
  return state.lidar_lever_arm_b_m + reading.arm_b_m +
         q_boresight * (mounting.R_bs_nominal * reading.u_s);
}

}  // namespace

PairCalibration::PairCalibration(const CalibrationState& state)
    : state_(state), lidar_(builder_internal::SharedEffects<LidarEffect>(state)) {
  const std::vector<const double*> values = builder_internal::EffectValues<LidarEffect>(state);
  std::vector<std::shared_ptr<const LidarEffect>> not_zero;
  for (std::size_t k = 0; k < values.size(); ++k) {
    const auto past = values[k] + lidar_[k]->components();
    if (std::all_of(values[k], past, [](double value) { return value == 0.0; })) continue;
    not_zero.push_back(lidar_[k]);
    values_.push_back(values[k]);
  }
  not_zero_ = std::move(not_zero);
}

EndIncrements::EndIncrements(const ImuData& imu, const CalibrationState& calibration,
                             const PreintegrationNoise& noise, double node_t_s,
                             const ImuCorrection& biases)
    : imu_(imu),
      node_t_s_(node_t_s),
      correction_(builder_internal::CorrectionWith(calibration, biases)),
      growing_(imu_, node_t_s, correction_, noise) {}

Preintegrated EndIncrements::To(double epoch_s) {
  return epoch_s - node_t_s_ > kEpochRoundingS ? growing_.To(epoch_s)
                                               : IdentityIncrement(imu_, node_t_s_, correction_);
}

LidarEnd PrepareEnd(const Flight& flight, const PairCalibration& calibration, double tag_s,
                    const Eigen::Vector3d& u_s, EndAttachment at, Eigen::Matrix3d* covariance_m2) {
  const LidarReading reading = calibration.Read(tag_s, u_s);
  const double t_s = calibration.EmissionTime(reading);
  if (t_s < at.node.t_s - kEpochRoundingS) {
    throw InvalidInput("lidar time offset: the estimate of " + std::to_string(tag_s - t_s) +
                       " s exceeds the " + std::to_string(kLidarTimeMarginS) +
                       " s that can be estimated; correct the time tags of the pairs first");
  }
  LidarEnd end{tag_s, std::move(at.partial), u_s, at.node.p_mb};
  if (at.inertial) {
    end.bridge = std::make_shared<IncrementConditioning>(flight.frame, end.partial,
                                                         at.inertial->increments());
  }
  *covariance_m2 +=
      EndNoise(end, at.node.q_mb.toRotationMatrix(),
               ArmToPoint(flight.config.lidar->mounting, calibration.state(), reading));
  return end;
}

PreparedPair PreparePair(const Flight& flight, const PairCalibration& calibration,
                         const LidarPair& pair, EndAttachment i, EndAttachment j) {
  const LidarConfig& lidar = *flight.config.lidar;
  Eigen::Matrix3d covariance_m2 = pair.covariance_m2.value_or(
      Eigen::Matrix3d(lidar.sigma_p_m * lidar.sigma_p_m * Eigen::Matrix3d::Identity()));
  LidarEnd end_i =
      PrepareEnd(flight, calibration, pair.t_i_s, pair.u_i_s, std::move(i), &covariance_m2);
  LidarEnd end_j =
      PrepareEnd(flight, calibration, pair.t_j_s, pair.u_j_s, std::move(j), &covariance_m2);
  return {std::move(end_i), std::move(end_j), lidar.mounting.R_bs_nominal,
          calibration.state().lidar_time_offset_s,
          builder_internal::MeasurementNoise(0.5 * (covariance_m2 + covariance_m2.transpose()),
                                             "the point pair", pair.t_i_s, kCheckPair)};
}

std::shared_ptr<const FactorBase> MakePairFactor(const LocalFrame& frame,
                                                 const PairCalibration& calibration,
                                                 const PreparedPair& pair) {
  const CalibrationState& state = calibration.state();
  if (PairEffectIndices(state).empty() && !pair.i.bridge && !pair.j.bridge) {
    return std::make_shared<PointToPoint>(frame, pair);
  }
  return std::make_shared<PointToPointBetweenNodes>(
      frame, pair, calibration.lidar(), GravitationJacobians(state, pair.i.p_nominal_m));
}

}  // namespace dn
