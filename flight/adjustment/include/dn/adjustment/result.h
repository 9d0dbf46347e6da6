#pragma once

#include <dn/adjustment/adjust.h>
#include <dn/adjustment/finding.h>
#include <dn/geo/trajectory.h>
#include <dn/report/statistics.h>
#include <dn/solvers/marginals.h>

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// Standard deviations of the trajectory at one node.
struct TrajectorySigma {
  double t_s = 0.0;
  Eigen::Vector3d position_enu_m;
  Eigen::Vector3d velocity_enu_mps;
  Eigen::Vector3d rph_rad;  ///< roll, pitch, heading
};

/// Total bias of one node with its standard deviation. The total bias of an axis is the sum of its
/// processes.
struct BiasEstimate {
  double t_s = 0.0;
  Eigen::Vector3d gyro_radps;
  Eigen::Vector3d accel_mps2;
  Eigen::Vector3d sigma_gyro_radps;
  Eigen::Vector3d sigma_accel_mps2;
};

/// Correlation of the boresight (rows roll, pitch, yaw) with the total bias (columns x, y, z).
struct BiasCorrelation {
  /// Correlation at the node nearest the mean lidar epoch.
  Eigen::Matrix3d at_barycentre = Eigen::Matrix3d::Zero();
  double max_abs = 0.0;  ///< over all nodes and axes
  double rms = 0.0;
};

/// Estimate of a calibration unknown other than the boresight: the correction of its assumed value.
struct UnknownEstimate {
  std::string name;
  std::string unit;
  std::vector<double> value;
  std::vector<double> sigma;
};

/// Summary figures of an adjustment.
struct AdjustmentFigures {
  double sigma0 = 0.0;  ///< sqrt(chi2 / redundancy)
  double chi2 = 0.0;    ///< twice the cost
  long redundancy = 0;  ///< residuals - parameters
  int iterations = 0;
  bool converged = false;
  long nodes = 0;
  long parameters = 0;
  long imu_epochs = 0;
  long gnss_epochs = 0;      ///< number kept
  long correspondences = 0;  ///< number kept
  long outliers = 0;
  long surface_pairs = 0;  ///< number kept
  long surface_outliers = 0;
};

/// Trajectory of an adjusted flight: posterior sigmas, biases and statistics.
struct TrajectoryResult {
  std::vector<TrajectorySigma> sigma;  ///< at the nodes
  std::vector<BiasEstimate> biases;    ///< at the nodes
  AdjustmentFigures figures;
  Eigen::VectorXd redundancy;  ///< RedundancyNumbers of all rows of the linearised network
  std::vector<SeriesStatistics> residuals;  ///< whitened, after the fit, per sensor and axis
  /// Innovations of the diffuse-prior forward filter, per sensor and axis.
  std::vector<SeriesStatistics> innovations;
  double nis_position = 0.0;      ///< mean normalised innovation squared / 3, expected 1
  double nis_velocity = 0.0;      ///< the same; 0 without velocities
  std::vector<Finding> warnings;  ///< warnings from the statistics
};

/// The part that one effect outside of the model has in a result and its covariance.
struct EffectContribution {
  std::string effect;
  std::string unit;
  std::string remedy;        ///< what would make the part smaller
  Eigen::VectorXd estimate;  ///< posterior mean of each component, in `unit`
  Eigen::VectorXd sigma;     ///< posterior standard deviations
  Eigen::VectorXd prior;     ///< prior standard deviations
  /// Roots of the decrease of the variances of three angles if the effect were known exactly. They
  /// are the angles of the boresight, or else of the attitude about the body axes (root mean square
  /// along the flight).
  Eigen::Vector3d angle_sigma_rad = Eigen::Vector3d::Zero();
};

/// Angles and covariance without the effects that the model leaves out.
struct ModelledBoresight {
  Eigen::Vector3d angles_rad = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_rad2 = Eigen::Matrix3d::Zero();

  Eigen::Vector3d sigma_rad() const { return covariance_rad2.diagonal().cwiseSqrt(); }
  Eigen::Matrix3d correlation() const;
};

/// The boresight with its posterior covariance and its verdict.
struct BoresightResult {
  /// Rotation vector about the body axes, total.
  Eigen::Vector3d angles_rad = Eigen::Vector3d::Zero();
  Eigen::Vector3d euler_zyx_rad = Eigen::Vector3d::Zero();  ///< roll, pitch, yaw of Exp(angles)
  Eigen::Matrix3d covariance_rad2 = Eigen::Matrix3d::Zero();
  double condition_number = 0.0;  ///< of the reduced normal matrix
  BiasCorrelation accel_bias;
  BiasCorrelation gyro_bias;
  /// Sigmas from the inverse of the normal matrix, and the same times sigma0. They are set by
  /// methods whose reliable covariance is a different one.
  std::optional<Eigen::Vector3d> sigma_apriori_rad;
  std::optional<Eigen::Vector3d> sigma_scaled_rad;
  /// Result of the pure model, if angles and covariance contain effects that it leaves out.
  std::optional<ModelledBoresight> as_modelled;
  std::vector<EffectContribution> contributions;  ///< of these effects, the largest first
  Verdict verdict = Verdict::kCalibrated;
  std::vector<Finding> reasons;  ///< the deciding ones first

  Eigen::Vector3d sigma_rad() const { return covariance_rad2.diagonal().cwiseSqrt(); }
  Eigen::Matrix3d correlation() const;
};

/// Returns the pairs that have an end of this scanner.
std::vector<LidarPair> ScannerPairs(const Flight& flight, std::size_t scanner);

/// Returns the angle that a single pair of a scanner resolves, rad: its sigma_p at the mean range.
double PairResolution(const Flight& flight, std::size_t scanner = 0);

/// Sets the verdict to not observable, and adds the reasons, if a standard deviation exceeds 0.5
/// deg.
void AssessLargestSigma(const Eigen::Vector3d& sigma_rad, BoresightResult* result);

/// Sets the verdict to not observable, and adds the reasons, if two angles correlate by more than
/// 0.999. Otherwise sets it to calibrated.
void AssessSeparability(BoresightResult* result);

/// Sets the verdict to not observable, and adds the reasons, in three cases:
///   - two angles are inseparable (AssessSeparability);
///   - a sigma exceeds ten times PairResolution plus three times the attitude sigma, which no
///     geometry reduces;
///   - none of these, but a sigma exceeds 0.5 deg (AssessLargestSigma).
/// Otherwise sets it to calibrated.
///
/// `sigma_rad` are the sigmas of the boresight, `attitude_sigma_rad` those of the trajectory's
/// attitude.
void AssessObservability(const Flight& flight, const Eigen::Vector3d& sigma_rad,
                         const Eigen::Vector3d& attitude_sigma_rad, BoresightResult* result,
                         std::size_t scanner = 0);

/// Returns the posterior covariances of the trajectory and of the biases, figures, and statistics.
/// `marginals` must have its selected inverse.
TrajectoryResult ExtractTrajectory(const Adjustment& adjustment, const Marginals& marginals);

/// Returns the boresight of a scanner with its covariance and its correlations with all biases. The
/// verdict is that of AssessObservability, and absorbed instead of calibrated if the adjustment has
/// warnings. Throws RankDeficient if the boresight is constant.
BoresightResult ExtractBoresight(const Adjustment& adjustment, const Marginals& marginals,
                                 std::size_t scanner = 0);

/// Returns the covariance at t_s of the total bias (per axis, the sum of its processes), in
/// (rad/s)^2 or (m/s^2)^2. It is zero without processes. `marginals` must have its selected
/// inverse.
Eigen::Matrix3d TotalBiasCovariance(const std::vector<ProcessChain>& chains, double t_s,
                                    const Marginals& marginals);

/// Returns the other estimated unknowns with their standard deviations.
std::vector<UnknownEstimate> ExtractUnknowns(const Adjustment& adjustment,
                                             const Marginals& marginals);

/// Returns the adjusted trajectory at all nodes, and between them at the sample epochs that are at
/// least min_spacing_s after the previous point. Each node's pose is propagated through the
/// inertial samples; the closing error at the next node is distributed linearly. The result does
/// not depend on the number of threads.
std::vector<NavPoint> DenseTrajectory(const FlightNetwork& network, double min_spacing_s,
                                      int threads = 1);

}  // namespace dn
