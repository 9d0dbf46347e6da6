#pragma once

#include <dn/builder/calibration_state.h>
#include <dn/factor.h>
#include <dn/factors/lidar_effect.h>
#include <dn/factors/lidar_point.h>
#include <dn/factors/preintegrated_inertial.h>
#include <dn/files/flight.h>
#include <dn/geo/trajectory.h>
#include <dn/imu/preintegration.h>
#include <dn/noise.h>

#include <Eigen/Core>
#include <memory>
#include <vector>

namespace dn {

/// Returns the covariance of a GNSS position in the map frame, m^2. It is the covariance of the
/// file or else the default of the flight, scaled by sigma_scale^2 and rotated from local ENU axes.
Eigen::Matrix3d GnssPositionCovariance(const MapGnssEpoch& epoch, const GnssConfig& config);

/// Returns gnss.processes as processes of a chain with sigma 1: the blocks are in units of the
/// configured sigmas (see CorrelatedGnssError).
std::vector<BiasProcess> GnssProcessesInSigmas(const GnssConfig& config);

/// Returns the largest sigma of a GNSS position along an axis, m. It includes the white noise of
/// the first epoch and the time-correlated processes.
double TypicalGnssSigma(const Flight& flight);

/// Returns whether the velocity of an epoch is used: it and its covariance are present, and
/// gnss.use_velocity does not exclude it.
bool UsesVelocity(const MapGnssEpoch& epoch, const GnssConfig& config);

/// Returns the time of an epoch with this time tag: the tag minus the delays of the calibration.
double GnssEpochTime(const CalibrationState& calibration, double tag_s);

/// Input to the factors of a GNSS epoch.
struct GnssEdgeInput {
  MapPose pose;  ///< pose of a node near the epoch; the motion of the antenna starts from it
  ImuCorrection biases;  ///< biases at that node, used for the angular rate
  /// Added to the covariance of the file, map axes, m^2 for a position and (m/s)^2 for a velocity.
  Eigen::Matrix3d added_covariance = Eigen::Matrix3d::Zero();
};

/// Returns the position factor of an epoch. Without time-correlated errors and GNSS effects it is a
/// GnssPosition on (q_mb, p_mb, a_b). Otherwise it is a GnssAntenna on (q_mb, p_mb, a_b, v_m), the
/// values of gnss.processes (CorrelatedGnssError), and the effects in the order of
/// GnssEffectIndices. Throws InvalidInput with the time of the epoch if its covariance is not
/// finite and positive definite.
std::shared_ptr<const FactorBase> MakeGnssPositionFactor(const Flight& flight,
                                                         const MapGnssEpoch& epoch,
                                                         const CalibrationState& calibration,
                                                         const GnssEdgeInput& input);

/// Returns the velocity factor of an epoch that has a velocity. Without GNSS effects it is a
/// GnssVelocity on (q_mb, v_m, a_b). Otherwise it is a GnssAntenna as above, but without the
/// time-correlated errors, which affect positions only. Throws InvalidInput like
/// MakeGnssPositionFactor.
std::shared_ptr<const FactorBase> MakeGnssVelocityFactor(const Flight& flight,
                                                         const MapGnssEpoch& epoch,
                                                         const CalibrationState& calibration,
                                                         const GnssEdgeInput& input);

/// Returns the Jacobian of the gravitation at p_m for every effect on gravitation, in the order of
/// the blocks of the factors.
std::vector<GravitationBasis> GravitationJacobians(const CalibrationState& calibration,
                                                   const Eigen::Vector3d& p_m);

/// Input that attaches one end of a pair to its node.
struct PairEndInput {
  MapPose node;
  ImuCorrection biases;
  /// Inertial factor that starts at the node, under the same calibration. The noise of the end is
  /// then conditioned on the rotation to the next node (IncrementConditioning). Null: no
  /// conditioning.
  std::shared_ptr<const PreintegratedInertial> inertial = {};
  /// Preintegrated increments from the node to the epoch of the end. Null: they are integrated
  /// here.
  const Preintegrated* partial = nullptr;
};

/// A pair and the nodes to which its ends are attached.
struct PairEdgeInput {
  LidarPair pair;
  PairEndInput i, j;
};

/// The parts from which the factor of a pair is made.
struct PairParts {
  LidarEnd i, j;  ///< the partial increments end at the epochs under this calibration
  double tag_i_s = 0.0, tag_j_s = 0.0;  ///< time tags in the pair file
  Eigen::Matrix3d T_bs_nominal = Eigen::Matrix3d::Identity();
  double dt_nominal_s = 0.0;  ///< delay of the time tags used for the partial increments, s
  /// Noise of the difference of the two points, map axes: the noise of the pair and of its partial
  /// increments.
  Noise<3> noise_m;
};

/// A calibration prepared for the readings of many pairs: the effects on the lidar are looked up
/// once. The CalibrationState must outlive this object.
class PairCalibration {
 public:
  explicit PairCalibration(const CalibrationState& state);

  const CalibrationState& state() const { return state_; }
  const LidarEffects& lidar() const { return lidar_; }

  /// Returns a reading corrected for the effects on the lidar, without derivatives.
  LidarReading Read(double tag_s, const Eigen::Vector3d& u_s) const {
    return Corrected(not_zero_, values_.data(), tag_s, u_s);
  }
  /// Returns the emission time of the beam of a reading, s.
  double EmissionTime(const LidarReading& reading) const {
    return reading.tag_s - (state_.lidar_time_offset_s + reading.delay_s);
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

/// Returns the parts of the factor of a pair. Throws InvalidInput if an epoch is earlier than its
/// node.
PairParts MakePairParts(const Flight& flight, const PairCalibration& calibration,
                        const PreintegrationNoise& noise, const PairEdgeInput& input);

/// Returns the factor of a pair. Without IncrementConditioning and without effects on pairs it is a
/// PointToPoint. Otherwise it is a PointToPointBetweenNodes with the effects in the order of
/// PairEffectIndices. Throws InvalidInput like MakePairParts.
std::shared_ptr<const FactorBase> MakePairFactor(const Flight& flight,
                                                 const PairCalibration& calibration,
                                                 const PreintegrationNoise& noise,
                                                 const PairEdgeInput& input);

/// Least time from the node of a pair end to its time tag if a time parameter of the lidar is
/// estimated, s. Estimates up to this delay then stay after the node.
inline constexpr double kLidarTimeMarginS = 0.05;

}  // namespace dn
