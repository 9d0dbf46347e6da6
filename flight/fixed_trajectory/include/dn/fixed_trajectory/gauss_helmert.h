#pragma once

#include <dn/fixed_trajectory/laser_unknowns.h>
#include <dn/network.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <vector>

namespace dn {

/// One end of a point pair: the observed pose at its epoch and the laser vector.
struct GaussHelmertEnd {
  double t_s = 0.0;                                          ///< epoch; not used by the adjustment
  Eigen::Quaterniond q_mb = Eigen::Quaterniond::Identity();  ///< attitude, body -> map
  Eigen::Vector3d p_mb = Eigen::Vector3d::Zero();            ///< body origin in map, m
  /// Rotation from the local north-east-down frame n at the point to the map. Its axes are those of
  /// sigma_ned_m.
  Eigen::Quaterniond q_mn = Eigen::Quaterniond::Identity();
  /// Standard deviation of the position: north, east, down.
  Eigen::Vector3d sigma_ned_m = Eigen::Vector3d::Zero();
  /// Standard deviation of roll, pitch, heading.
  Eigen::Vector3d sigma_rph_rad = Eigen::Vector3d::Zero();
  /// Laser vector in the body frame before rotation by the boresight, R_bs_nominal u_s, m.
  Eigen::Vector3d u_b = Eigen::Vector3d::Zero();
  int beam = -1;     ///< number of the laser beam, -1: unknown; not used by the adjustment
  LaserTerms laser;  ///< how u_b depends on the LaserUnknowns of the problem

  /// Returns the unit vector down in the body frame.
  Eigen::Vector3d down_b() const { return q_mb.conjugate() * (q_mn * Eigen::Vector3d::UnitZ()); }
};

/// One ground point observed at two epochs.
struct GaussHelmertPair {
  GaussHelmertEnd i, j;
  /// Covariance of the point difference from matching and ranging, map axes.
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
};

/// Input of the boresight adjustment with a fixed trajectory.
struct GaussHelmertProblem {
  /// Lever arm from the body origin to the scanner.
  Eigen::Vector3d lever_arm_b_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();  ///< initial value
  /// Prior standard deviation; without a value the boresight is free.
  std::optional<Eigen::Vector3d> boresight_sigma_rad;
  LaserUnknowns laser;  ///< unknowns of the laser vectors, estimated with the boresight
  /// Rotation from ECEF to map. Only libor_compat uses it.
  Eigen::Quaterniond q_me = Eigen::Quaterniond::Identity();
  std::vector<GaussHelmertPair> pairs;
};

/// Model of the rotation of a laser vector by the boresight theta.
enum class BoresightModel {
  /// u = Exp([theta]x) u_b, linearised at the current theta; theta <- Log(Exp(d) Exp(theta)).
  kExponential,
  kSmallAngle,  ///< u = (I + [theta]x) u_b, as in the paper; theta <- theta + d
};

/// Options of the Gauss-Helmert adjustment.
struct GaussHelmertOptions {
  BoresightModel model = BoresightModel::kExponential;
  /// Reproduces the public code libor, which uses the small-angle model and does not correct the
  /// observations between iterations. It rotates the attitude noise by R_me instead of R_mn, and
  /// takes the position noise along ECEF axes. It also stops after five iterations, and iterates
  /// only once after the outlier step.
  bool libor_compat = false;
  /// After convergence, pairs whose |w| exceeds this multiple of the median |w| are dropped once,
  /// and the remaining pairs are adjusted again. The step is skipped with a robust loss; 0 disables
  /// it.
  double outlier_medians = 3.0;
  /// Robust loss on sqrt(w^T S w), applied by iteratively reweighted least squares instead of the
  /// outlier step. If the model holds, sqrt(w^T S w) has a chi distribution with three degrees of
  /// freedom (mean 1.6).
  Loss loss;
  int max_iterations = 100;
  /// Bound on the norm of the estimated remaining change of the boresight.
  double tolerance_rad = 1e-11;
  int threads = 1;  ///< number of threads; the result does not depend on it

  /// Throws InvalidConfig naming the option, its value and its bound.
  void Validate() const;
};

/// Corrections of the twelve observations of a pair: position of i in map (m), attitude of i (rad),
/// position of j, attitude of j. An attitude correction is a right perturbation, a rotation vector
/// about the body axes.
using PairCorrection = Eigen::Matrix<double, 12, 1>;

/// Condition equations of one pair, linearised at the corrected observations.
struct PairLinearisation {
  Eigen::Vector3d w;               ///< p_i - p_j at the corrected observations, m
  Eigen::Matrix3d A;               ///< d w / d boresight (theta), m/rad
  Eigen::Matrix<double, 3, 12> B;  ///< d w / d corrections v
};

/// Returns w, A and B of a pair at the boresight theta_rad and the corrections v:
///
///   w = p_i - p_j,   p_k = p_mb + v_p + R_hat s,   R_hat = R_mb Exp(v_phi),   s = u + a_b
///   A = -R_hat_i [u_i]x + R_hat_j [u_j]x      u = Exp([theta]x) u_b     (small angle: [u_b]x)
///   B = [ I, -R_hat_i [s_i]x Jr(v_phi_i), -I, R_hat_j [s_j]x Jr(v_phi_j) ]
///
/// The paper's derivatives with respect to roll, pitch and heading are the attitude columns of B
/// times BodyFromEulerRates. Corrections given as rotation vectors have no singularity in pitch.
/// Source: Brun & Skaloud, appendix.
PairLinearisation LinearisePair(const GaussHelmertPair& pair, const Eigen::Vector3d& lever_arm_b_m,
                                BoresightModel model, const Eigen::Vector3d& theta_rad,
                                const PairCorrection& v);

/// Adjusted boresight with its covariances.
struct GaussHelmertResult {
  Eigen::Vector3d boresight_rad;             ///< theta: rotation vector about the body axes
  Eigen::VectorXd laser;                     ///< LaserUnknowns of the problem
  Eigen::MatrixXd laser_covariance_apriori;  ///< their covariance with the boresight unknown
  /// N for a left perturbation with the laser unknowns eliminated, including the prior if there is
  /// one, rad^-2
  Eigen::Matrix3d normal;
  Eigen::Matrix3d covariance_apriori_rad2;  ///< N^-1
  Eigen::Matrix3d covariance_scaled_rad2;   ///< sigma0^2 N^-1
  double condition_number = 0.0;            ///< lambda_max / lambda_min of N
  double sigma0 = 0.0;                      ///< sqrt(chi2 / redundancy)
  double chi2 = 0.0;               ///< v^T P v + r^T W r + prior term, with robust weights applied
  double chi2_observations = 0.0;  ///< v^T P v: contribution of the trajectory observations
  double chi2_conditions = 0.0;    ///< r^T W r: contribution of the pair conditions
  long redundancy = 0;             ///< 3 pairs - 3 (+ 3 with a prior)
  int iterations = 0;              ///< total over all stages
  bool converged = false;
  /// Mean |w| with the given trajectory and the initial boresight.
  double residual_initial_m = 0.0;
  double residual_final_m = 0.0;  ///< mean |w| of the kept pairs at the final boresight
  long pairs_kept = 0;
  /// Weight of each pair: 0 if it was dropped, otherwise its robust weight.
  std::vector<double> weights;
  long outliers = 0;  ///< pairs that were dropped or have a robust weight below 0.5
  std::vector<PairCorrection> corrections;  ///< corrections v of each pair at the solution

  Eigen::Matrix3d correlation() const;
};

/// Estimates the boresight by the Gauss-Helmert adjustment of point-to-point conditions:
///
///   minimise   sum_k  v_k^T P_k v_k + r_k^T W_k r_k,      r_k = w_k(theta, l_k + v_k)
///
/// Each iteration linearises at the latest boresight and the latest corrected observations l + v
/// (Pope's rigorous iteration), with w~ = w - B v. It eliminates v pair by pair,
///
///   S = (W^-1 + B P^-1 B^T)^-1                                    3 x 3
///   N = sum A^T S A,  d theta = -N^-1 sum A^T S w~,
///   v = -P^-1 B^T S (A d theta + w~),
///
/// so neither B nor P is formed as a whole: time and memory are linear in the number of pairs. P^-1
/// contains the squares of sigma_ned_m and sigma_rph_rad, rotated into map and body axes. The
/// twelve observations of a pair are treated as independent, even if two pairs share an epoch.
///
/// N^-1 is the covariance only if the trajectory errors are white, that is, independent between
/// epochs. Real trajectory errors are correlated in time: see trajectory_scatter.h.
///
/// The laser unknowns x of the problem are estimated with theta. A has a column for each of them
/// then, and their prior x^T P_x x is a part of the sum. Memory grows by their number squared.
///
/// Throws InvalidInput if there are fewer than two different pairs, or if a value is not finite.
/// Also throws it if a sigma is not positive, a covariance is not positive definite, or a term
/// names no laser unknown. Throws RankDeficient, naming the direction, if the pairs leave a
/// direction of the boresight undetermined; InvalidConfig for bad options. Missing convergence is
/// reported in the result, not thrown.
///
/// Source: Brun & Skaloud, eqs. of the linearised model and appendix; Pope (1972) for the
/// iteration.
[[nodiscard]] GaussHelmertResult AdjustGaussHelmert(const GaussHelmertProblem& problem,
                                                    const GaussHelmertOptions& options = {});

}  // namespace dn
