#pragma once

#include <dn/builder/calibration_state.h>
#include <dn/factor.h>
#include <dn/factors/lidar_effect.h>
#include <dn/factors/lidar_point.h>
#include <dn/factors/preintegrated_inertial.h>
#include <dn/flight/flight.h>
#include <dn/geo/trajectory.h>
#include <dn/imu/preintegration.h>
#include <dn/noise.h>

#include <Eigen/Core>
#include <memory>
#include <vector>

namespace dn {

/// Noise of a GNSS epoch's position in the mapping frame: the file's covariance or the flight's
/// default, scaled, rotated from the ENU of the point.
Eigen::Matrix3d GnssPositionCovariance(const MapGnssEpoch& epoch, const GnssConfig& config);

/// The processes of gnss.processes as those of a chain: of unit sigma, see GnssError.
std::vector<BiasProcess> GnssProcessesInSigmas(const GnssConfig& config);

/// Largest sigma of a GNSS position along an axis, by the flight's first epoch: white noise and
/// processes together, m.
double TypicalGnssSigma(const Flight& flight);

/// Whether the velocity of an epoch is used: by the configuration, else when it is there with its
/// sigma.
bool UsesVelocity(const MapGnssEpoch& epoch, const GnssConfig& config);

/// The time of an epoch with this tag: the tag less the delays that the calibration knows.
double GnssEpochTime(const CalibrationState& calibration, double tag_s);

/// What an edge of a GNSS epoch is made with.
struct GnssEdgeInput {
  MapPose pose;          ///< of a node near the epoch, from where the antenna has its way
  ImuCorrection biases;  ///< biases there, for the angular rate
  /// Added to the covariance of the file, map axes, m^2 or (m/s)^2.
  Eigen::Matrix3d added_covariance = Eigen::Matrix3d::Zero();
};

/// Position edge of an epoch. Without lasting errors and GNSS effects a GnssPosition on (q_mb, p_mb,
/// a_b), else a GnssAntenna on (q_mb, p_mb, a_b, v_m), the values of gnss.processes (GnssError) and
/// the effects in the order of EffectsOfGnss. Throws InvalidInput naming the epoch where its
/// covariance is none.
std::shared_ptr<const FactorBase> MakeGnssPositionFactor(const Flight& flight,
                                                         const MapGnssEpoch& epoch,
                                                         const CalibrationState& calibration,
                                                         const GnssEdgeInput& input);

/// Velocity edge of an epoch that has one: a GnssVelocity on (q_mb, v_m, a_b), or where there are GNSS
/// effects a GnssAntenna as above, without the lasting errors, which are those of positions.
std::shared_ptr<const FactorBase> MakeGnssVelocityFactor(const Flight& flight,
                                                         const MapGnssEpoch& epoch,
                                                         const CalibrationState& calibration,
                                                         const GnssEdgeInput& input);

/// The attraction of every effect on it at p_m, in the order of the factors' blocks.
std::vector<AttractionBasis> AttractionBases(const CalibrationState& calibration,
                                             const Eigen::Vector3d& p_m);

/// How an end of a pair hangs on its node.
struct PairEndInput {
  MapPose node;
  ImuCorrection biases;
  /// Inertial edge that begins at the node, under the same calibration: a bridge to the attitude of
  /// its other node; null: none.
  std::shared_ptr<const PreintegratedInertial> inertial = {};
  /// From the node to the epoch of the end; null: integrated here.
  const Preintegrated* partial = nullptr;
};

/// A pair with how its ends hang on their nodes.
struct PairEdgeInput {
  LidarPair pair;
  PairEndInput i, j;
};

/// What the factor of a pair is made of.
struct PairParts {
  LidarEnd i, j;  ///< their partial increments end at the epochs that the calibration says
  double tag_i_s = 0.0, tag_j_s = 0.0;  ///< of the file
  Eigen::Matrix3d T_bs_nominal = Eigen::Matrix3d::Identity();
  double dt_nominal_s = 0.0;  ///< delay of the tags with which the increments were cut
  /// Of the difference of the two points, map axes: that of the pair and of its increments.
  Noise<3> noise_m;
};

/// A calibration, which must outlive it, as many pairs take it: what corrects their readings is
/// looked up once.
class PairCalibration {
 public:
  explicit PairCalibration(const CalibrationState& state);

  const CalibrationState& state() const { return state_; }
  const LidarEffects& lidar() const { return lidar_; }

  /// Without derivatives.
  LidarReading Read(double tag_s, const Eigen::Vector3d& u_s) const {
    return Corrected(not_zero_, values_.data(), tag_s, u_s);
  }
  /// When the beam of a reading left, s.
  double EpochOf(const LidarReading& reading) const {
    return reading.tag_s - (state_.lidar_time_offset_s + reading.delay_s);
  }

 private:
  const CalibrationState& state_;
  LidarEffects lidar_;
  LidarEffects not_zero_;              // those that change a reading
  std::vector<const double*> values_;  // of each of them
};

/// The increments from a node to the epochs of ends that hang on it, in the order of time.
class EndIncrements {
 public:
  EndIncrements(const ImuData& imu, const CalibrationState& calibration,
                const PreintegrationNoise& noise, double node_t_s, const ImuCorrection& biases);

  Preintegrated To(double epoch_s);

 private:
  const ImuData& imu_;
  double node_t_s_;
  ImuCorrection correction_;
  GrowingIncrements growing_;
};

/// Throws InvalidInput when an epoch falls before its node.
PairParts MakePairParts(const Flight& flight, const PairCalibration& calibration,
                        const PreintegrationNoise& noise, const PairEdgeInput& input);

/// Edge of a pair. Without bridges and effects on pairs a PointToPoint, else a
/// PointToPointBetweenNodes with the effects in the order of EffectsOfPairs. Throws InvalidInput as
/// MakePairParts.
std::shared_ptr<const FactorBase> MakePairFactor(const Flight& flight,
                                                 const PairCalibration& calibration,
                                                 const PreintegrationNoise& noise,
                                                 const PairEdgeInput& input);

/// With a time of the lidar free, pairs attach to a node at least this far before their tag, s.
inline constexpr double kLidarTimeMarginS = 0.05;

}  // namespace dn
