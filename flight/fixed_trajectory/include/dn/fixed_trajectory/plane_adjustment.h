#pragma once

#include <dn/solvers/gauss_helmert.h>
#include <dn/solvers/trajectory_scatter.h>

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace dn {

/// A point of a plane: the observed pose of its epoch, and what the scanner saw.
struct PlanePoint {
  GaussHelmertEnd end;
  int strip = 0;
};

/// A plane that several strips see.
struct SeenPlane {
  std::vector<PlanePoint> points;
  /// Noise of a point across the plane, m: ranging, footprint and roughness.
  double sigma_m = 0.0;
};

/// A boresight from planes on a fixed trajectory.
struct PlaneProblem {
  Eigen::Vector3d lever_arm_b_m = Eigen::Vector3d::Zero();  ///< scanner in body
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();  ///< initial value
  std::optional<Eigen::Vector3d> boresight_sigma_rad;       ///< prior on it; absent: free
  bool with_range_offset = false;              ///< estimate it: measured range = true + value
  std::optional<double> range_offset_sigma_m;  ///< prior on it about zero; absent: free
  std::vector<SeenPlane> planes;
};

/// Options of the plane adjustment.
struct PlaneAdjustmentOptions {
  /// A plane whose points have more than this many times the median rms of all planes is left out
  /// (two strips hold different surfaces); 0: no such step.
  double plane_medians = 3.0;
  /// A point whose residual exceeds this many standard deviations, by the median of all, is left
  /// out, once; 0: no such step.
  double point_sigmas = 3.0;
  int max_iterations = 100;      ///< of each of the two steps
  double tolerance_rad = 1e-10;  ///< norm of the last change of the boresight
  int threads = 1;               ///< the result does not depend on it

  /// Throws InvalidConfig naming the option, its value and its bound.
  void Validate() const;
};

/// A plane n . (p - centre) = d.
struct PlaneState {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  ///< map; held fixed
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double d_m = 0.0;
};

/// The plane with its normal changed by the tangent t and its distance by d.
///   n <- (n + t_1 e_1 + t_2 e_2) / |.|,   d <- d + t_3,   e_1, e_2 of PlaneTangent
PlaneState Changed(const PlaneState& plane, const Eigen::Vector3d& t);

/// Two unit vectors across the normal.
Eigen::Matrix<double, 3, 2> PlaneTangent(const Eigen::Vector3d& normal);

/// The condition of one point, linearised.
struct PlanePointLinearisation {
  double f_m = 0.0;                                   ///< n . (p - centre) - d
  Eigen::Vector3d J_theta = Eigen::Vector3d::Zero();  ///< by the boresight, m/rad
  double J_range = 0.0;                               ///< by the range offset
  Eigen::Vector3d J_plane = Eigen::Vector3d::Zero();  ///< by the tangent of the plane
  Eigen::Vector3d J_phi = Eigen::Vector3d::Zero();    ///< by the attitude, right, m/rad
  double variance_m2 = 0.0;  ///< of f, by the white errors of pose, laser vector and surface
};

/// f, its derivatives and its variance at the boresight theta_rad and the range offset rho_m:
///
///   f = n . (p - c) - d,    p = p_mb + R_mb (u + a_b),    u = Exp([theta]x) u_b (1 - rho / |u_b|)
///   s^2 = n^T (P + F A F^T) n + sigma^2,                   F = -R_mb [u + a_b]x
///
/// P, A: covariances of position and attitude that the point's end states.
PlanePointLinearisation LinearisePlanePoint(const PlanePoint& point, double sigma_m,
                                            const Eigen::Vector3d& lever_arm_b_m,
                                            const Eigen::Vector3d& theta_rad, double rho_m,
                                            const PlaneState& plane);

/// How the normals of planes are spread.
struct NormalSpread {
  /// Eigenvalues of the mean of n n^T over the planes, ascending; their sum is 1.
  Eigen::Vector3d eigenvalues = Eigen::Vector3d::Zero();
};

/// The adjusted boresight with its covariances.
struct PlaneAdjustment {
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();
  double range_offset_m = 0.0;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();  ///< all else eliminated; left perturbation
  /// Inverse normal matrix of boresight and range offset (where it is estimated).
  Eigen::MatrixXd covariance_apriori;
  Eigen::Matrix3d covariance_apriori_rad2 = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d covariance_scaled_rad2 = Eigen::Matrix3d::Zero();  ///< times sigma0^2
  double condition_number = 0.0;  ///< lambda_max / lambda_min of the normal matrix
  double sigma0 = 0.0;            ///< sqrt(chi2 / redundancy)
  double chi2 = 0.0;
  long redundancy = 0;  ///< points + priors - unknowns - 3 planes
  int iterations = 0;
  bool converged = false;
  double residual_initial_m = 0.0;  ///< mean |f| at the initial boresight, planes fitted
  double residual_final_m = 0.0;    ///< mean |f| of the points kept
  long points_kept = 0, planes_kept = 0;
  long points_left_out = 0;             ///< of planes kept
  std::vector<PlaneState> planes;       ///< of the problem
  std::vector<std::vector<char>> kept;  ///< per plane and point; all zero: the plane is left out
  NormalSpread normals;                 ///< of the planes kept
  std::map<std::pair<int, int>, long> planes_of_strips;  ///< kept, by two strips, ascending
};

/// Estimates the boresight from planes that several strips see:
///
///   minimise  sum_q sum_k f_qk^2 / s_qk^2,      f_qk = n_q . (p_qk(theta, rho) - c_q) - d_q
///
/// by Gauss-Newton with three unknowns per plane (its normal on the unit sphere, its distance),
/// which are eliminated plane by plane (3 x 3), so that time and memory are linear in the points.
/// The trajectory is held fixed: its errors only enter the weight, and they are taken as new at
/// every point. They are not: see EstimateTrajectoryScatter.
///
/// Planes with fewer than three kept points in each of two strips take no part. Outliers: first
/// planes (plane_medians, until the choice repeats), then points (point_sigmas, Baarda), once.
///
/// Throws InvalidInput for a value that is not finite, a sigma that is not positive, and points of
/// a plane on a line; RankDeficient when no plane is seen by two strips, or the planes leave a
/// direction free, naming it; InvalidConfig for bad options. Not to converge is reported.
///
/// Source: Skaloud & Lichti (2006), Rigorous approach to bore-sight self-calibration in airborne
/// laser scanning, ISPRS J. 61.
[[nodiscard]] PlaneAdjustment AdjustPlanes(const PlaneProblem& problem,
                                           const PlaneAdjustmentOptions& options = {});

/// How the time-correlated errors of the trajectory scatter what planes estimate.
struct PlaneScatter {
  TrajectoryScatter trajectory;
  double range_offset_m2 = 0.0;  ///< variance of the range offset by the same errors
};

/// EstimateTrajectoryScatter of a plane adjustment: the planes are eliminated with the boresight.
/// Throws InvalidConfig for bad options, InvalidInput when the result is of another problem.
PlaneScatter EstimateTrajectoryScatter(const PlaneProblem& problem, const PlaneAdjustment& result,
                                       const TrajectoryScatterOptions& options);

/// ReliableCovariance of a plane adjustment.
Eigen::Matrix3d ReliableCovariance(const PlaneAdjustment& result, const TrajectoryScatter& scatter,
                                   const Eigen::Matrix3d& constant_rad2);

}  // namespace dn
