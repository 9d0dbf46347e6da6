#pragma once

#include <dn/calibration/adjust.h>
#include <dn/calibration/finding.h>
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

/// Total bias (sum of the processes of an axis) at one node, with its standard deviation.
struct BiasEstimate {
  double t_s = 0.0;
  Eigen::Vector3d gyro_radps;
  Eigen::Vector3d accel_mps2;
  Eigen::Vector3d sigma_gyro_radps;
  Eigen::Vector3d sigma_accel_mps2;
};

/// Correlation of the boresight (rows roll, pitch, yaw) with the total bias (columns x, y, z).
struct BiasCorrelation {
  Eigen::Matrix3d at_barycentre =
      Eigen::Matrix3d::Zero();  ///< at the node nearest the mean lidar epoch
  double max_abs = 0.0;         ///< over all nodes and axes
  double rms = 0.0;
};

/// One estimated calibration unknown besides the boresight: correction to the assumed value.
struct UnknownEstimate {
  std::string name;
  std::string unit;
  std::vector<double> value;
  std::vector<double> sigma;
};

/// Figures of an adjustment.
struct AdjustmentFigures {
  double sigma0 = 0.0;  ///< sqrt(chi2 / redundancy)
  double chi2 = 0.0;    ///< twice the cost
  long redundancy = 0;  ///< residuals - parameters
  int iterations = 0;
  bool converged = false;
  long nodes = 0;
  long parameters = 0;
  long imu_epochs = 0;
  long gnss_epochs = 0;      ///< kept
  long correspondences = 0;  ///< kept
  long outliers = 0;
};

/// The trajectory part of an adjusted flight with its posterior covariance.
struct TrajectoryResult {
  std::vector<TrajectorySigma> sigma;  ///< at the nodes
  std::vector<BiasEstimate> biases;    ///< at the nodes
  AdjustmentFigures figures;
  Eigen::VectorXd redundancy;  ///< RedundancyNumbers of every row of the linearised network
  std::vector<SeriesStatistics> residuals;    ///< whitened, after the fit, per sensor and axis
  std::vector<SeriesStatistics> innovations;  ///< of the forward filter, per sensor and axis
  double nis_position = 0.0;                  ///< mean normalised innovation squared / 3
  double nis_velocity = 0.0;                  ///< 0 without velocities
  std::vector<Finding> warnings;              ///< what the statistics say against the assumed model
};

/// The boresight with its posterior covariance.
struct BoresightResult {
  Eigen::Vector3d angles_rad =
      Eigen::Vector3d::Zero();  ///< rotation vector about the body axes, total
  Eigen::Vector3d euler_zyx_rad = Eigen::Vector3d::Zero();  ///< roll, pitch, yaw of Exp(angles)
  Eigen::Matrix3d covariance_rad2 = Eigen::Matrix3d::Zero();
  double condition_number = 0.0;  ///< of the reduced normal matrix
  BiasCorrelation accel_bias;
  BiasCorrelation gyro_bias;
  /// Of methods whose reliable covariance is not the inverse of their normal matrix: from that, and
  /// the same times sigma0.
  std::optional<Eigen::Vector3d> sigma_apriori_rad;
  std::optional<Eigen::Vector3d> sigma_scaled_rad;
  Verdict verdict = Verdict::kCalibrated;
  std::vector<Finding> reasons;  ///< those that decide first

  Eigen::Vector3d sigma_rad() const { return covariance_rad2.diagonal().cwiseSqrt(); }
  Eigen::Matrix3d correlation() const;
};

/// What a single pair resolves: its own sigma_p at the mean range, rad.
double PairResolution(const Flight& flight);

/// Sets the verdict to not observable, with the reasons, where a standard deviation exceeds 0.5 deg.
void AssessLargestSigma(const Eigen::Vector3d& sigma_rad, BoresightResult* result);

/// Sets the verdict to not observable, with the reasons, when two angles correlate by more than
/// 0.999. Else calibrated.
void AssessSeparability(BoresightResult* result);

/// Sets the verdict to not observable, with the reasons, when two angles correlate by more than 0.999,
/// a standard deviation that the geometry leaves exceeds ten times PairResolution, beyond three
/// times the attitude sigma that no geometry helps against, or else as AssessLargestSigma says.
/// Else calibrated.
void AssessObservability(const Flight& flight, const Eigen::Vector3d& sigma_rad,
                         const Eigen::Vector3d& attitude_sigma_rad, BoresightResult* result);

/// Posterior covariances of the trajectory and of the biases, figures, and statistics. `marginals`
/// must have its selected inverse.
TrajectoryResult ExtractTrajectory(const Adjustment& adjustment, const Marginals& marginals);

/// The boresight with covariance and its correlations with every bias. Throws RankDeficient when it
/// is held.
BoresightResult ExtractBoresight(const Adjustment& adjustment, const Marginals& marginals);

/// Covariance of the total bias (sum of the processes of an axis) that holds at t_s, in (rad/s)^2
/// or (m/s^2)^2; zero without processes. `marginals` must have its selected inverse.
Eigen::Matrix3d TotalBiasCovariance(const std::vector<ProcessChain>& chains, double t_s,
                                    const Marginals& marginals);

/// The other estimated unknowns with their standard deviations.
std::vector<UnknownEstimate> ExtractUnknowns(const Adjustment& adjustment,
                                             const Marginals& marginals);

/// The adjusted trajectory between the nodes: strapdown propagation from each node through the
/// inertial samples, the closing error at the next node spread linearly. Every sample epoch at
/// least min_spacing_s after the last, and every node. The same for any number of threads.
std::vector<NavPoint> DenseTrajectory(const FlightNetwork& network, double min_spacing_s,
                                      int threads = 1);

}  // namespace dn
