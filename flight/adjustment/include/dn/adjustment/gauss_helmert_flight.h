#pragma once

#include <dn/adjustment/beams.h>
#include <dn/adjustment/result.h>
#include <dn/files/flight.h>
#include <dn/fixed_trajectory/gauss_helmert.h>
#include <dn/fixed_trajectory/trajectory_scatter.h>

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// Accuracy of a trajectory at the epochs of the pairs, as stated by its files or by flight.yaml.
/// The sigmas are root mean squares over the epochs.
struct TrajectoryAccuracy {
  Eigen::Vector3d sigma_ned_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_rph_rad = Eigen::Vector3d::Zero();
  /// Mean covariance of the attitude in body axes, rad^2: the covariance of an error that is
  /// constant in body.
  Eigen::Matrix3d attitude_covariance_rad2 = Eigen::Matrix3d::Zero();
  std::string source;  ///< name of the file, or "the section trajectory of flight.yaml"
  SigmaSource sigma_source = SigmaSource::kDataSheet;
  /// Covariance of the poses over time, from `trajectory_covariance.txt`. It is absent if that file
  /// does not exist or does not cover the epochs of all pairs.
  std::optional<PoseCovariance> covariance = {};
};

/// Method and accuracy of the pose interpolation at the pairs' epochs.
struct PoseInterpolation {
  std::string method;
  double median_step_s = 0.0;
  /// Rms and maximum of the angle between cubic and linear interpolation at the pairs' epochs, rad.
  /// They bound the error of the cubic interpolation.
  double cubic_minus_linear_rms_rad = 0.0;
  double cubic_minus_linear_max_rad = 0.0;
};

/// Geometry of the strips, with the criteria of the operating envelope in the paper.
struct StripDiversity {
  int strips = 0;
  bool crossing = false;  ///< the courses of two strips differ by 20 deg or more, modulo 180 deg
  bool heights = false;   ///< the heights of two strips differ by 5 % of the range or more

  /// Returns true for four strips, or for three if one crosses or has another height.
  bool sufficient() const { return strips >= 4 || (strips == 3 && (crossing || heights)); }
};

/// A flight adjusted on its fixed trajectory: problem, adjustment and covariances.
struct GaussHelmertCalibration {
  GaussHelmertProblem problem;
  GaussHelmertOptions options;
  GaussHelmertResult adjustment;
  CorrelatedErrorCovariance scatter;
  TrajectoryAccuracy accuracy;
  /// Covariance of the attitude error that is constant over the flight, rad^2 in body. It is the
  /// part of the trajectory's attitude covariance that, according to the pairs, does not vary.
  Eigen::Matrix3d constant_rad2 = Eigen::Matrix3d::Zero();
  PoseInterpolation interpolation;
  StripDiversity diversity;
  double mean_range_m = 0.0;
  /// Boresight with its reliable covariance; sigma_apriori_rad and sigma_scaled_rad are set.
  BoresightResult boresight;
  /// Corrections of the beams of a scanner with several beams. The laser vectors of the problem
  /// contain them.
  std::vector<BeamCorrections> beams;
  AdjustmentFigures figures;
  double solve_time_s = 0.0;
  double covariance_time_s = 0.0;
};

/// Options of CalibrateGaussHelmert and CalibratePlanes.
struct GaussHelmertFlightOptions {
  int threads = 1;
  std::function<void(const std::string& stage)> progress = {};
  std::function<bool()> interrupted = {};  ///< polled between stages; true throws Interrupted
  VectorOrigin vectors = {};               ///< of planes alone; pairs have theirs in PairData
};

/// Returns the adjustment problem for the pairs of a flight on its trajectory. The poses are
/// interpolated by PoseInterpolator (linearly with gh.libor_compat, as in libor). P is from the
/// section `trajectory`, W from the pairs' covariances or lidar.sigma_p_m, and the prior from
/// lidar.boresight_sigma_deg. `interpolation` may be null.
///
/// Throws InvalidInput with the times if the epoch of a pair is outside the trajectory.
GaussHelmertProblem MakeGaussHelmertProblem(const Flight& flight, int threads = 1,
                                            PoseInterpolation* interpolation = nullptr);

/// Returns the accuracy of a trajectory from the first of these sources that exists:
///   1. the file that trajectory.sigma_file names;
///   2. the smoother's files next to the trajectory: `trajectory_covariance.txt` (if it covers the
///      pairs) and `trajectory_sigma.txt` of `dn smooth`, or smrmsg of POSPac;
///   3. the section `trajectory` of flight.yaml.
/// Throws InvalidInput with the epoch if the file does not cover the pairs or a sigma is not
/// positive. Throws it too if the two files are of different runs.
TrajectoryAccuracy ReadTrajectoryAccuracy(const Flight& flight, const GaussHelmertProblem& problem);

/// Estimates the boresight of a flight with a trajectory and pairs by the Gauss-Helmert adjustment.
/// lidar.robust: `none` is the outlier rule of the paper, `huber` and `cauchy` are robust losses of
/// width 2.5.
///
/// If flight.yaml has `beams` and the pairs name them, their corrections are estimated, too
/// (BeamUnknown). gh.libor_compat leaves them out.
///
/// The covariance is ReliableCovariance. The verdict, with its reasons, is
///   not_observable  by AssessObservability for the normal matrix, or by AssessLargestSigma for the
///                   reliable sigmas;
///   absorbed        the attitude errors of the trajectory at the two epochs of a pair (as stated,
///                   or as the pairs show if that is more) change its difference by more than half
///                   its own sigma, and exceed 0.01 deg in roll or pitch or 0.02 deg in heading.
///                   The angles make the cloud consistent, but contain that error;
///   calibrated      otherwise.
///
/// The model itself is not tested; CheckModel does that (`dn::diagnosis`).
///
/// Throws InvalidConfig if `estimate` does not name the boresight; InvalidInput, RankDeficient,
/// NotConverged, Interrupted.
GaussHelmertCalibration CalibrateGaussHelmert(const Flight& flight,
                                              const GaussHelmertFlightOptions& options = {});

/// Difference of two boresight results of one flight.
struct MethodDifference {
  Eigen::Vector3d difference_rad = Eigen::Vector3d::Zero();   ///< a - b, a left perturbation
  Eigen::Matrix3d covariance_rad2 = Eigen::Matrix3d::Zero();  ///< covariance of the difference
  double mahalanobis2 = 0.0;                                  ///< d^T C^-1 d
  double p_value = 1.0;  ///< of mahalanobis2, chi-square with three degrees of freedom

  Eigen::Vector3d sigma_rad() const { return covariance_rad2.diagonal().cwiseSqrt(); }
};

/// Compares the results of two methods. `b` must use all data of `a` and more, and be efficient if
/// its model holds. The dynamic network is efficient because it uses all data at once. The error of
/// `b` is then uncorrelated with the difference, whose covariance is C_a - C_b. In directions in
/// which `a` is more accurate it is C_b - C_a. The variance in any direction is at least a tenth of
/// the larger of the two, because the covariances themselves are not known better. Source: Hausman
/// (1978), corollary 2.6.
MethodDifference Compare(const BoresightResult& a, const BoresightResult& b);

/// Compares results that share no data: the covariance of the difference is C_a + C_b.
MethodDifference CompareIndependent(const BoresightResult& a, const BoresightResult& b);

/// Changes the verdict of a Gauss-Helmert result from `calibrated` to `absorbed` if the dynamic
/// network contradicts it (p < 0.0027, three sigma). Both must be of the same flight. Adds the
/// comparison to the reasons.
void AssessAgainstNetwork(const BoresightResult& network, GaussHelmertCalibration* gauss_helmert);

}  // namespace dn
