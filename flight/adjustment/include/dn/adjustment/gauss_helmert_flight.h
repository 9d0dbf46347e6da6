#pragma once

#include <dn/calibration/model_check.h>
#include <dn/calibration/result.h>
#include <dn/flight/flight.h>
#include <dn/solvers/gauss_helmert.h>
#include <dn/solvers/trajectory_scatter.h>

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// What the trajectory states about its own accuracy at the epochs of the pairs (root mean
/// squares).
struct TrajectoryAccuracy {
  Eigen::Vector3d sigma_ned_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_rph_rad = Eigen::Vector3d::Zero();
  /// Mean covariance of the attitude in body axes, rad^2: that of an error constant in body.
  Eigen::Matrix3d attitude_covariance_rad2 = Eigen::Matrix3d::Zero();
  std::string source;  ///< name of the file, or "the section trajectory of flight.yaml"
  StatedBy stated_by = StatedBy::kDataSheet;
  /// From `trajectory_covariance.txt` where there is one, at the epochs of all pairs: how the
  /// errors of the smoother correlate in time.
  std::optional<PoseCovariance> covariance = {};
};

/// How the poses at the pairs' epochs came about.
struct PoseInterpolation {
  std::string method;
  double median_step_s = 0.0;
  /// rms and maximum of the angle between cubic and linear interpolation at the pairs' epochs, rad:
  /// a bound of the error of the cubic one.
  double cubic_minus_linear_rms_rad = 0.0;
  double cubic_minus_linear_max_rad = 0.0;
};

/// The geometry of the strips as the paper's operating envelope asks for it.
struct StripDiversity {
  int strips = 0;
  bool crossing = false;  ///< two strips whose courses differ by 20 deg or more, modulo 180 deg
  bool heights = false;   ///< two strips whose heights differ by 5 % of the range or more

  /// Four strips, or three of which one crosses or lies at another height.
  bool sufficient() const { return strips >= 4 || (strips == 3 && (crossing || heights)); }
};

/// A flight adjusted on its fixed trajectory, with what stands behind the result.
struct GaussHelmertCalibration {
  GaussHelmertProblem problem;
  GaussHelmertOptions options;
  GaussHelmertResult adjustment;
  TrajectoryScatter scatter;
  TrajectoryAccuracy accuracy;
  /// Of the attitude error that is constant over the flight, rad^2 in body: the share of the
  /// trajectory's attitude covariance that the pairs do not show to vary.
  Eigen::Matrix3d constant_rad2 = Eigen::Matrix3d::Zero();
  PoseInterpolation interpolation;
  StripDiversity diversity;
  double mean_range_m = 0.0;
  /// With the reliable covariance; sigma_apriori_rad and sigma_scaled_rad beside it.
  BoresightResult boresight;
  ModelCheck model_check;
  AdjustmentFigures figures;
  double solve_time_s = 0.0;
  double covariance_time_s = 0.0;
};

/// How the adjustment on a fixed trajectory runs.
struct GaussHelmertFlightOptions {
  int threads = 1;
  std::function<void(const std::string& stage)> progress = {};
  std::function<bool()> interrupted = {};  ///< polled between stages; true throws Interrupted
};

/// The problem of a flight's pairs on its trajectory: poses interpolated (PoseInterpolator; with
/// gh.libor_compat linearly, as libor does), P from the section `trajectory`, W from the pairs'
/// covariances or lidar.sigma_p_m, the prior of lidar.boresight_sigma_deg.
/// Throws InvalidInput naming the times when a pair's epoch lies outside the trajectory.
GaussHelmertProblem MakeGaussHelmertProblem(const Flight& flight, int threads = 1,
                                            PoseInterpolation* interpolation = nullptr);

/// From what the smoother wrote beside the trajectory's file: `trajectory_covariance.txt` (where it
/// covers the pairs) and `trajectory_sigma.txt`, as `dn smooth` writes them, or POSPac's smrmsg;
/// from the one that trajectory.sigma_file names; or else from the section `trajectory`. Throws
/// InvalidInput naming the epoch when the file does not cover the pairs, or a sigma is not
/// positive; when the two files are of different runs.
TrajectoryAccuracy ReadTrajectoryAccuracy(const Flight& flight, const GaussHelmertProblem& problem);

/// Boresight of a flight with a trajectory and pairs by the Gauss-Helmert adjustment. lidar.robust:
/// none is the paper's outlier rule, huber and cauchy are robust losses of width 2.5.
///
/// The covariance is ReliableCovariance; the verdict is
///   not_observable  as AssessObservability says of the normal matrix, AssessLargestSigma of the
///                   reliable sigmas,
///   absorbed        the attitude errors of the trajectory at the two epochs of a pair (stated, or
///                   shown by the pairs where that is more) change its difference by more than
///                   half its own sigma, and exceed 0.01 deg in roll or pitch or 0.02 deg in
///                   heading: the angles make the cloud consistent, but hold that error,
///   contradicted    the pairs show an effect of the lidar (time tags, lever arm, ranges, scan
///                   angles) that moves the boresight by more than its sigma, the misclosures have
///                   more than twice their stated variance beside the effects found, more than 30 %
///                   of the pairs are outliers, the stated prior contradicts the pairs, or an angle
///                   exceeds 15 deg (model_check); wins over the others,
///   calibrated      else,
/// with the reasons. Effects are looked for beside errors of the trajectory that last, of
/// the stated size or larger. Hidden stay those that look like such errors: late tags in quiet
/// flight, a lever arm in strips at one height, a mount that moves, and an attitude error that is
/// constant over the flight. Throws InvalidConfig when `estimate` does not name the boresight;
/// InvalidInput, RankDeficient, NotConverged, Interrupted.
GaussHelmertCalibration CalibrateGaussHelmert(const Flight& flight,
                                              const GaussHelmertFlightOptions& options = {});

/// Difference of two results of one flight.
struct MethodDifference {
  Eigen::Vector3d difference_rad = Eigen::Vector3d::Zero();   ///< a - b, a left perturbation
  Eigen::Matrix3d covariance_rad2 = Eigen::Matrix3d::Zero();  ///< of the difference
  double mahalanobis2 = 0.0;                                  ///< d^T C^-1 d
  double p_value = 1.0;  ///< of it, chi-square with three degrees of freedom

  Eigen::Vector3d sigma_rad() const { return covariance_rad2.diagonal().cwiseSqrt(); }
};

/// `b` uses all that `a` does, and more (the dynamic network: all data at once), and is efficient
/// where its model holds. Its error is then uncorrelated with the difference, which hence has the
/// covariance C_a - C_b; in a direction in which `a` is the better one, C_b - C_a. None is taken for
/// less than a tenth of the larger: better that one itself is not known.
/// Source: Hausman (1978), corollary 2.6.
MethodDifference Compare(const BoresightResult& a, const BoresightResult& b);

/// Of results that share no data: the covariance of the difference is C_a + C_b.
MethodDifference CompareIndependent(const BoresightResult& a, const BoresightResult& b);

/// Turns the verdict of a Gauss-Helmert result to `absorbed` where the dynamic network of the same
/// flight contradicts it (p < 0.0027, three sigma), and adds the comparison to the reasons.
void AssessAgainstNetwork(const BoresightResult& network, GaussHelmertCalibration* gauss_helmert);

}  // namespace dn
