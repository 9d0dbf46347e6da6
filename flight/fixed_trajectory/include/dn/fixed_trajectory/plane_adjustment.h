#pragma once

#include <dn/fixed_trajectory/gauss_helmert.h>
#include <dn/fixed_trajectory/trajectory_scatter.h>

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

namespace dn {

/// A point on a plane: the observed pose at its epoch, the laser vector and the strip.
struct PlanePoint {
  GaussHelmertEnd end;
  int strip = 0;
};

/// A plane that several strips observe.
struct ObservedPlane {
  std::vector<PlanePoint> points;
  /// Standard deviation of a point normal to the plane, m: ranging, footprint and roughness.
  double sigma_m = 0.0;
};

/// Input of the boresight adjustment by planes with a fixed trajectory.
struct PlaneProblem {
  /// Lever arm from the body origin to the scanner.
  Eigen::Vector3d lever_arm_b_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();  ///< initial value
  /// Prior standard deviation; without a value the boresight is free.
  std::optional<Eigen::Vector3d> boresight_sigma_rad;
  /// True: the range offset is estimated; measured range = true range + offset.
  bool with_range_offset = false;
  /// Prior standard deviation about zero; without a value the offset is free.
  std::optional<double> range_offset_sigma_m;
  LaserUnknowns laser;  ///< unknowns of the laser vectors, estimated with the boresight
  std::vector<ObservedPlane> planes;

  /// Unknowns besides the planes: the boresight, the range offset if it is estimated, and the laser
  /// unknowns, in this order.
  Eigen::Index NumUnknowns() const { return FirstLaser() + laser.size(); }
  Eigen::Index FirstLaser() const { return with_range_offset ? 4 : 3; }
};

/// Options of the plane adjustment.
struct PlaneAdjustmentOptions {
  /// A plane is left out if the rms of its points exceeds this multiple of the median rms of all
  /// planes. Its strips probably observe different surfaces. 0 disables the step.
  double plane_medians = 3.0;
  /// A point is left out, once, if its residual exceeds this many standard deviations; the standard
  /// deviation is estimated from the median of all residuals. 0 disables the step.
  double point_sigmas = 3.0;
  int max_iterations = 100;      ///< limit for each of the two outlier steps
  double tolerance_rad = 1e-10;  ///< bound on the norm of the last change of the boresight
  int threads = 1;               ///< number of threads; the result does not depend on it

  /// Throws InvalidConfig naming the option, its value and its bound.
  void Validate() const;
};

/// The plane n . (p - centre) = d.
struct PlaneState {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  ///< a fixed point in the map frame
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double d_m = 0.0;
};

/// Returns the plane with its normal and its distance changed by the tangent vector t:
///   n <- (n + t_1 e_1 + t_2 e_2) / |.|,   d <- d + t_3,   e_1, e_2 of PlaneTangent
PlaneState Changed(const PlaneState& plane, const Eigen::Vector3d& t);

/// Returns two orthogonal unit vectors perpendicular to the normal.
Eigen::Matrix<double, 3, 2> PlaneTangent(const Eigen::Vector3d& normal);

/// Condition equation of one point, linearised.
struct PlanePointLinearisation {
  double f_m = 0.0;                                   ///< n . (p - centre) - d
  Eigen::Vector3d J_theta = Eigen::Vector3d::Zero();  ///< d f / d boresight, m/rad
  double J_range = 0.0;                               ///< d f / d range offset
  /// d f / d laser unknown of each term of the point.
  std::array<double, std::tuple_size_v<LaserTerms>> J_laser{};
  Eigen::Vector3d J_plane = Eigen::Vector3d::Zero();  ///< d f / d tangent vector of the plane
  /// d f / d attitude (right perturbation), m/rad.
  Eigen::Vector3d J_phi = Eigen::Vector3d::Zero();
  /// Variance of f from the white errors of pose, laser vector and surface.
  double variance_m2 = 0.0;
};

/// Returns f, its derivatives and its variance at the boresight theta_rad and the range offset
/// rho_m:
///
///   f = n . (p - c) - d,    p = p_mb + R_mb (u + a_b),    u = Exp([theta]x) u_b (1 - rho / |u_b|)
///   s^2 = n^T (P + F A F^T) n + sigma^2,                   F = -R_mb [u + a_b]x
///
/// P and A are the covariances of position and attitude from the sigmas of the point's end.
/// `laser_change` is that of the laser unknowns from their start; empty: zero.
PlanePointLinearisation LinearisePlanePoint(const PlanePoint& point, double sigma_m,
                                            const Eigen::Vector3d& lever_arm_b_m,
                                            const Eigen::Vector3d& theta_rad, double rho_m,
                                            const PlaneState& plane,
                                            const Eigen::VectorXd& laser_change = {});

/// Derivatives of a condition with respect to the unknowns of PlaneProblem::NumUnknowns, without
/// those that are zero.
struct PlaneUnknownRow {
  static constexpr std::size_t kMost = 4 + std::tuple_size_v<LaserTerms>;
  std::array<Eigen::Index, kMost> at{};
  std::array<double, kMost> value{};
  std::size_t size = 0;

  PlaneUnknownRow(const PlaneProblem& problem, const PlanePoint& point,
                  const PlanePointLinearisation& linear);
};

/// Distribution of the plane normals.
struct NormalSpread {
  /// Eigenvalues of the mean of n n^T over the planes, ascending; their sum is 1.
  Eigen::Vector3d eigenvalues = Eigen::Vector3d::Zero();
};

/// Adjusted boresight with its covariances.
struct PlaneAdjustment {
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();
  double range_offset_m = 0.0;
  Eigen::VectorXd laser;  ///< LaserUnknowns of the problem
  /// All other unknowns eliminated; left perturbation.
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  /// Inverse normal matrix of the unknowns of PlaneProblem::NumUnknowns.
  Eigen::MatrixXd covariance_apriori;
  Eigen::Matrix3d covariance_apriori_rad2 = Eigen::Matrix3d::Zero();
  /// covariance_apriori_rad2 times sigma0^2.
  Eigen::Matrix3d covariance_scaled_rad2 = Eigen::Matrix3d::Zero();
  double condition_number = 0.0;  ///< lambda_max / lambda_min of the normal matrix
  double sigma0 = 0.0;            ///< sqrt(chi2 / redundancy)
  double chi2 = 0.0;
  long redundancy = 0;  ///< points + priors - unknowns - 3 planes
  int iterations = 0;
  bool converged = false;
  double residual_initial_m = 0.0;  ///< mean |f| at the initial boresight, after fitting the planes
  double residual_final_m = 0.0;    ///< mean |f| of the kept points
  long points_kept = 0, planes_kept = 0;
  long points_left_out = 0;             ///< number of points left out of the kept planes
  std::vector<PlaneState> planes;       ///< one per plane of the problem
  std::vector<std::vector<char>> kept;  ///< per plane and point; all zero if the plane is left out
  NormalSpread normals;                 ///< distribution of the normals of the kept planes
  /// Number of kept planes for each pair of strips (ascending).
  std::map<std::pair<int, int>, long> planes_by_strips;
};

/// Estimates the boresight from planes that several strips observe:
///
///   minimise  sum_q sum_k f_qk^2 / s_qk^2,      f_qk = n_q . (p_qk(theta, rho) - c_q) - d_q
///
/// by Gauss-Newton. Each plane has three unknowns: its normal on the unit sphere and its distance.
/// They are eliminated plane by plane (3 x 3), so time and memory are linear in the number of
/// points. The trajectory is fixed: its errors only enter the weights and are treated as
/// independent between points. Real trajectory errors are correlated in time: see
/// EstimateCorrelatedErrorCovariance.
///
/// Planes that do not have three kept points in each of two strips are not used. Outliers are
/// removed in two steps: first planes (plane_medians, repeated until the selection does not
/// change), then points (point_sigmas, Baarda), once.
///
/// Throws InvalidInput for a value that is not finite, a sigma that is not positive, collinear
/// points of a plane, and a term that names no laser unknown. Throws RankDeficient if no plane is
/// observed by two strips, or if the planes leave a direction undetermined, naming that direction;
/// InvalidConfig for bad options. Missing convergence is reported in the result, not thrown.
///
/// Source: Skaloud & Lichti (2006), Rigorous approach to bore-sight self-calibration in airborne
/// laser scanning, ISPRS J. 61.
[[nodiscard]] PlaneAdjustment AdjustPlanes(const PlaneProblem& problem,
                                           const PlaneAdjustmentOptions& options = {});

/// Covariance of the plane adjustment from time-correlated trajectory errors.
struct PlaneErrorCovariance {
  CorrelatedErrorCovariance trajectory;
  double range_offset_m2 = 0.0;  ///< variance of the range offset from the same errors
};

/// Estimates the trajectory covariance as EstimateCorrelatedErrorCovariance does for pairs; the
/// planes are eliminated together with the boresight. Throws InvalidConfig for bad options, and
/// InvalidInput if the result belongs to another problem.
PlaneErrorCovariance EstimateCorrelatedErrorCovariance(const PlaneProblem& problem,
                                                       const PlaneAdjustment& result,
                                                       const TrajectoryErrorOptions& options);

}  // namespace dn
