#pragma once

#include <dn/builder/calibration_state.h>
#include <dn/factor.h>
#include <dn/files/flight.h>
#include <dn/geo/trajectory.h>
#include <dn/imu/preintegration.h>

#include <Eigen/Core>
#include <memory>
#include <vector>

namespace dn {

/// Returns the covariance of a GNSS position in the map frame, m^2. It is the covariance of the
/// file or else the default of the flight, scaled by sigma_scale^2 and rotated from local ENU axes.
Eigen::Matrix3d GnssPositionCovariance(const MapGnssEpoch& epoch, const GnssConfig& config);

/// Returns the covariance of the velocity of an epoch in the map frame, (m/s)^2. It is that of the
/// file, scaled by the square of velocity_sigma_scale, or else of sigma_scale.
Eigen::Matrix3d GnssVelocityCovariance(const MapGnssEpoch& epoch, const GnssConfig& config);

/// Returns gnss.processes as processes of a chain with sigma 1: the blocks are in units of the
/// configured sigmas (see CorrelatedGnssError).
std::vector<BiasProcess> GnssProcessesInSigmas(const GnssConfig& config);

/// Returns the largest sigma of a GNSS position along an axis, m. It includes the white noise of
/// the first epoch and the time-correlated processes, at the reference bank if they grow with it.
double TypicalGnssSigma(const Flight& flight);

/// Returns whether the velocity of an epoch is used: it and its covariance are present, and
/// gnss.use_velocity does not exclude it.
bool UsesVelocity(const MapGnssEpoch& epoch, const GnssConfig& config);
/// Returns whether the velocity of any epoch of a flight with GNSS data is used.
bool UsesVelocities(const Flight& flight);

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
/// GnssPosition on (q_mb, p_mb, a_b). Otherwise it is a GnssAntenna. Its blocks are q_mb, p_mb, a_b
/// and v_m, the values of gnss.processes (CorrelatedGnssError), and the effects in the order of
/// GnssEffectIndices. The processes have their sigmas at the attitude of the pose
/// (GnssProcessSigma). Throws InvalidInput with the time of the epoch if its covariance is not
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

}  // namespace dn
