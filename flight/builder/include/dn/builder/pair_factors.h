#pragma once

#include <dn/builder/calibration_state.h>
#include <dn/factor.h>
#include <dn/factors/lidar_effect.h>
#include <dn/factors/preintegrated_inertial.h>
#include <dn/factors/prepared_pair.h>
#include <dn/files/flight.h>
#include <dn/geo/trajectory.h>
#include <dn/imu/preintegration.h>
#include <dn/lidar/pairs.h>

#include <Eigen/Core>
#include <memory>
#include <vector>

namespace dn {

/// A laser vector with its time tag, scanner and beam.
struct LaserShot {
  double tag_s = 0.0;
  Eigen::Vector3d u_s = Eigen::Vector3d::Zero();
  int scanner = 0;
  int beam = kNoBeam;
};

/// Return the shots of the two ends of a pair.
inline LaserShot ShotI(const LidarPair& pair) {
  return {pair.t_i_s, pair.u_i_s, pair.scanner_i, pair.beam_i};
}
inline LaserShot ShotJ(const LidarPair& pair) {
  return {pair.t_j_s, pair.u_j_s, pair.scanner_j, pair.beam_j};
}

/// A calibration prepared for the readings of many pairs: the effects on the lidar are looked up
/// once. The CalibrationState must outlive this object.
class PairCalibration {
 public:
  explicit PairCalibration(const CalibrationState& state);

  const CalibrationState& state() const { return state_; }
  const LidarEffects& lidar() const { return lidar_; }

  /// Returns a reading corrected for the effects on the lidar, without derivatives.
  LidarReading Read(const LaserShot& shot) const {
    return Corrected(not_zero_, values_.data(), shot.tag_s, shot.u_s, shot.scanner, shot.beam);
  }
  /// Returns the emission time of the beam of a reading, s.
  double EmissionTime(const LidarReading& reading) const {
    const MountingState mounting = state_.MountingAt(static_cast<std::size_t>(reading.scanner));
    return reading.tag_s - (mounting.time_offset_s + reading.delay_s);
  }

 private:
  const CalibrationState& state_;
  LidarEffects lidar_;
  LidarEffects not_zero_;              // effects with a value other than zero
  std::vector<const double*> values_;  // one per effect of not_zero_
};

/// Preintegrated increments from a node to the epochs of pair ends attached to it. The epochs must
/// come in ascending order of time.
class EndIncrements {
 public:
  EndIncrements(const ImuData& imu, const CalibrationState& calibration,
                const PreintegrationNoise& noise, double node_t_s, const ImuCorrection& biases);

  Preintegrated To(double epoch_s);

 private:
  const ImuData& imu_;
  double node_t_s_;
  ImuCorrection correction_;
  IncrementalPreintegrator growing_;
};

/// The attachment of one end of a pair to its node.
struct EndAttachment {
  MapPose node;
  Preintegrated partial;  ///< increments from the node to the epoch of the end
  /// Inertial factor that starts at the node, under the same calibration. The noise of the end is
  /// then conditioned on the rotation to the next node (IncrementConditioning). Null: no
  /// conditioning.
  std::shared_ptr<const PreintegratedInertial> inertial = {};
};

/// Prepares the end of a laser vector for its factor, and adds the noise of its increments to the
/// covariance of the point. Throws InvalidInput if the epoch is earlier than the node.
LidarEnd PrepareEnd(const Flight& flight, const PairCalibration& calibration, const LaserShot& shot,
                    EndAttachment at, Eigen::Matrix3d* covariance_m2);

/// Prepares a pair for its factor. Throws InvalidInput if an epoch is earlier than its node, or if
/// the covariance of the pair is not finite and positive definite.
PreparedPair PreparePair(const Flight& flight, const PairCalibration& calibration,
                         const LidarPair& pair, EndAttachment i, EndAttachment j);

/// Returns the factor of a pair. Without IncrementConditioning, effects on pairs and a second
/// scanner it is a PointToPoint. Otherwise it is a PointToPointBetweenNodes with the effects in the
/// order of PairEffectIndices.
std::shared_ptr<const FactorBase> MakePairFactor(const LocalFrame& frame,
                                                 const PairCalibration& calibration,
                                                 const PreparedPair& pair);

/// Least time from the node of a pair end to its time tag if a time parameter of the lidar is
/// estimated, s. Estimates up to this delay then stay after the node.
inline constexpr double kLidarTimeMarginS = 0.05;

}  // namespace dn
