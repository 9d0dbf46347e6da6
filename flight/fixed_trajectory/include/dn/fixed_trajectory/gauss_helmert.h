#pragma once

#include <dn/network.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <vector>

namespace dn {

/// One end of a point pair: the observed pose of its epoch, and what the scanner saw.
struct GaussHelmertEnd {
  double t_s = 0.0;                                          ///< epoch; not used by the adjustment
  Eigen::Quaterniond q_mb = Eigen::Quaterniond::Identity();  ///< attitude, body -> map
  Eigen::Vector3d p_mb = Eigen::Vector3d::Zero();            ///< body origin in map, m
  /// Local north-east-down of the point -> map: the axes of the two sigmas below.
  Eigen::Quaterniond q_mn = Eigen::Quaterniond::Identity();
  Eigen::Vector3d sigma_ned_m = Eigen::Vector3d::Zero();    ///< of the position
  Eigen::Vector3d sigma_rph_rad = Eigen::Vector3d::Zero();  ///< of roll, pitch, heading
  Eigen::Vector3d u_b = Eigen::Vector3d::Zero();  ///< laser vector in the nominal body, T u_s, m
};

/// One ground point seen at two epochs.
struct GaussHelmertPair {
  GaussHelmertEnd i, j;
  Eigen::Matrix3d covariance_m2 =
      Eigen::Matrix3d::Zero();  ///< of the pair's difference itself (matching, ranging), map axes
};

/// The adjustment of a boresight from a fixed trajectory.
struct GaussHelmertProblem {
  Eigen::Vector3d lever_arm_b_m = Eigen::Vector3d::Zero();  ///< scanner in body
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();  ///< initial value
  std::optional<Eigen::Vector3d> boresight_sigma_rad;       ///< prior on it; absent: free
  /// ECEF -> map; used by libor_compat only.
  Eigen::Quaterniond q_me = Eigen::Quaterniond::Identity();
  std::vector<GaussHelmertPair> pairs;
};

/// How the boresight turns a laser vector.
enum class BoresightModel {
  kExponential,  ///< u = Exp([theta]x) T u_s, relinearised, theta <- Log(Exp(d) Exp(theta))
  kSmallAngle,   ///< u = (I + [theta]x) T u_s, as in the paper; theta <- theta + d
};

/// Options of the Gauss-Helmert adjustment.
struct GaussHelmertOptions {
  BoresightModel model = BoresightModel::kExponential;
  /// Reproduce the public code libor: its small-angle model, observations that are not corrected
  /// between iterations, attitude noise turned by R_me instead of R_mn (and position noise taken
  /// along ECEF axes), five iterations at most, one single iteration after the outlier step.
  bool libor_compat = false;
  /// Pairs whose |w| exceeds this many medians of |w| after convergence are dropped, once, and the
  /// rest is adjusted again. Only without a robust loss; 0: no such step.
  double outlier_medians = 3.0;
  /// Robust loss on sqrt(w^T S w), which has a chi distribution of three degrees of freedom where
  /// the model holds (mean 1.6): iteratively re-weighted least squares instead of the step above.
  Loss loss;
  int max_iterations = 100;
  double tolerance_rad = 1e-11;  ///< norm of the change of the boresight still to come
  int threads = 1;               ///< the result does not depend on it

  /// Throws InvalidConfig naming the option, its value and its bound.
  void Validate() const;
};

/// Corrections of the twelve observations of a pair: position of i in map (m), attitude of i
/// (right, rotation vector about the body axes, rad), position of j, attitude of j.
using PairCorrection = Eigen::Matrix<double, 12, 1>;

/// The condition of one pair at corrected observations, linearised.
struct PairLinearisation {
  Eigen::Vector3d w;               ///< p_i - p_j at the corrected observations, m
  Eigen::Matrix3d A;               ///< d w / d boresight, m/rad
  Eigen::Matrix<double, 3, 12> B;  ///< d w / d corrections
};

/// w, A and B of a pair at the boresight theta_rad and the corrections v:
///
///   w = p_i - p_j,   p_k = p_mb + v_p + R_hat s,   R_hat = R_mb Exp(v_phi),   s = u + a_b
///   A = -R_hat_i [u_i]x + R_hat_j [u_j]x      u = Exp([theta]x) u_b     (small angle: [u_b]x)
///   B = [ I, -R_hat_i [s_i]x Jr(v_phi_i), -I, R_hat_j [s_j]x Jr(v_phi_j) ]
///
/// The paper's derivatives by roll, pitch and heading are the attitude columns of B times
/// BodyFromEulerRates; corrections in the form of rotation vectors have no singular pitch.
/// Source: Brun & Skaloud, appendix.
PairLinearisation LinearisePair(const GaussHelmertPair& pair, const Eigen::Vector3d& lever_arm_b_m,
                                BoresightModel model, const Eigen::Vector3d& theta_rad,
                                const PairCorrection& v);

/// The adjusted boresight with its covariances.
struct GaussHelmertResult {
  Eigen::Vector3d boresight_rad;  ///< theta: rotation vector about the body axes
  Eigen::Matrix3d normal;         ///< N, of a left perturbation, with the prior if any, rad^-2
  Eigen::Matrix3d covariance_apriori_rad2;  ///< N^-1
  Eigen::Matrix3d covariance_scaled_rad2;   ///< sigma0^2 N^-1
  double condition_number = 0.0;            ///< lambda_max / lambda_min of N
  double sigma0 = 0.0;                      ///< sqrt(chi2 / redundancy)
  double chi2 = 0.0;                        ///< v^T P v + r^T W r + prior; robust weights applied
  double chi2_observations = 0.0;           ///< v^T P v, of the observations of the trajectory
  double chi2_conditions = 0.0;             ///< r^T W r, of the pairs' conditions
  long redundancy = 0;                      ///< 3 pairs - 3 (+ 3 with a prior)
  int iterations = 0;                       ///< of all stages
  bool converged = false;
  double residual_initial_m = 0.0;  ///< mean |w| with the given trajectory at the initial boresight
  double residual_final_m = 0.0;    ///< at the final one, of the pairs kept
  long pairs_kept = 0;
  /// Of each pair: 0 where it was dropped, else its robust weight.
  std::vector<double> weights;
  long outliers = 0;  ///< pairs dropped, or with a robust weight below one half
  std::vector<PairCorrection> corrections;  ///< v of each pair at the solution

  Eigen::Matrix3d correlation() const;
};

/// Estimates the boresight by the Gauss-Helmert adjustment of point-to-point conditions:
///
///   minimise   sum_k  v_k^T P_k v_k + r_k^T W_k r_k,      r_k = w_k(theta, l_k + v_k)
///
/// Each iteration linearises at the latest boresight and the latest corrected observations l + v
/// (Pope's rigorous iteration): w~ = w - B v, and eliminates v pair by pair,
///
///   S = (W^-1 + B P^-1 B^T)^-1                                    3 x 3
///   N = sum A^T S A,  d theta = -N^-1 sum A^T S w~,
///   v = -P^-1 B^T S (A d theta + w~),
///
/// so neither B nor P is ever formed as a whole: time and memory are linear in the number of pairs.
/// P^-1 holds sigma_ned_m and sigma_rph_rad squared, turned into map and body axes; the twelve
/// observations of a pair are independent, also where two pairs share an epoch.
///
/// N^-1 is the covariance when the errors of the trajectory are white, that is, new at every epoch.
/// They are not: see trajectory_scatter.h.
///
/// Throws InvalidInput when there are fewer than two different pairs, a value is not finite, a
/// sigma is not positive or a covariance not positive definite; RankDeficient when the pairs leave
/// a direction of the boresight free, naming it; InvalidConfig for bad options. Not to converge is
/// reported, not thrown.
///
/// Source: Brun & Skaloud, eqs. of the linearised model and appendix; Pope (1972) for the
/// iteration.
[[nodiscard]] GaussHelmertResult AdjustGaussHelmert(const GaussHelmertProblem& problem,
                                                    const GaussHelmertOptions& options = {});

}  // namespace dn
