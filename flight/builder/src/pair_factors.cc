#include <dn/builder/gravitation_jacobians.h>
#include <dn/builder/measurement_noise.h>
#include <dn/builder/pair_factors.h>
#include <dn/error.h>
#include <dn/factors/point_to_point.h>
#include <dn/factors/point_to_point_between_nodes.h>
#include <dn/files/scanners.h>
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
Eigen::Vector3d ArmToPoint(const FlightConfig& config, const CalibrationState& state,
                           const LidarReading& reading) {
  const auto k = static_cast<std::size_t>(reading.scanner);
  const MountingState mounting = state.MountingAt(k);
  const Eigen::Quaterniond q_boresight =
      reading.turn_b_rad.isZero(0.0)
          ? mounting.q_boresight
          : Exp(Eigen::Vector3d(Log(mounting.q_boresight) + reading.turn_b_rad));
  return mounting.lever_arm_b_m + reading.arm_b_m +
         q_boresight * (ScannerAt(config, k).mounting.R_bs_nominal * reading.u_s);
}

const Eigen::Matrix3d& NominalMounting(const FlightConfig& config, int scanner) {
  return ScannerAt(config, static_cast<std::size_t>(scanner)).mounting.R_bs_nominal;
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

LidarEnd PrepareEnd(const Flight& flight, const PairCalibration& calibration, const LaserShot& shot,
                    EndAttachment at, Eigen::Matrix3d* covariance_m2) {
  const LidarReading reading = calibration.Read(shot);
  const double t_s = calibration.EmissionTime(reading);
  if (t_s < at.node.t_s - kEpochRoundingS) {
    throw InvalidInput("lidar time offset: the estimate of " + std::to_string(shot.tag_s - t_s) +
                       " s exceeds the " + std::to_string(kLidarTimeMarginS) +
                       " s that can be estimated; correct the time tags of the pairs first");
  }
  LidarEnd end{shot.tag_s, std::move(at.partial), shot.u_s, at.node.p_mb};
  end.scanner = shot.scanner;
  end.beam = shot.beam;
  if (at.inertial) {
    end.bridge = std::make_shared<IncrementConditioning>(flight.frame, end.partial,
                                                         at.inertial->increments());
  }
  *covariance_m2 += EndNoise(end, at.node.q_mb.toRotationMatrix(),
                             ArmToPoint(flight.config, calibration.state(), reading));
  return end;
}

PreparedPair PreparePair(const Flight& flight, const PairCalibration& calibration,
                         const LidarPair& pair, EndAttachment i, EndAttachment j) {
  const double sigma_m = PairSigma(flight.config, pair);
  Eigen::Matrix3d covariance_m2 =
      pair.covariance_m2.value_or(Eigen::Matrix3d(sigma_m * sigma_m * Eigen::Matrix3d::Identity()));
  LidarEnd end_i = PrepareEnd(flight, calibration, ShotI(pair), std::move(i), &covariance_m2);
  LidarEnd end_j = PrepareEnd(flight, calibration, ShotJ(pair), std::move(j), &covariance_m2);
  const MountingState mounting =
      calibration.state().MountingAt(static_cast<std::size_t>(pair.scanner_i));
  PreparedPair prepared{
      std::move(end_i), std::move(end_j), NominalMounting(flight.config, pair.scanner_i),
      mounting.time_offset_s,
      builder_internal::MeasurementNoise(0.5 * (covariance_m2 + covariance_m2.transpose()),
                                         "the point pair", pair.t_i_s, kCheckPair)};
  if (pair.scanner_j != pair.scanner_i) {
    prepared.R_bs_nominal_j = NominalMounting(flight.config, pair.scanner_j);
  }
  return prepared;
}

std::shared_ptr<const FactorBase> MakePairFactor(const LocalFrame& frame,
                                                 const PairCalibration& calibration,
                                                 const PreparedPair& pair) {
  const CalibrationState& state = calibration.state();
  if (PairEffectIndices(state).empty() && !pair.i.bridge && !pair.j.bridge &&
      !pair.R_bs_nominal_j) {
    return std::make_shared<PointToPoint>(frame, pair);
  }
  return std::make_shared<PointToPointBetweenNodes>(
      frame, pair, calibration.lidar(), GravitationJacobians(state, pair.i.p_nominal_m));
}

}  // namespace dn
