#pragma once

#include <dn/fixed_trajectory/gauss_helmert.h>

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace dn {

/// Joint covariance of the trajectory errors at some epochs. Between epochs the errors are linear
/// in time.
struct PoseCovariance {
  std::vector<double> t_s;  ///< increasing
  /// Strip of each epoch, not decreasing; the errors are undefined between strips.
  std::vector<int> strip;
  /// Six rows per epoch: position in map axes (m), attitude as a rotation vector in body axes (rad,
  /// q_mb Exp(d)).
  Eigen::MatrixXd covariance;

  /// Throws InvalidConfig naming the inconsistent or invalid value.
  void Validate() const;
};

/// Origin of the sigmas of a trajectory.
enum class SigmaSource {
  /// Smoother output for this flight: known within a factor of 1.3, common to position and
  /// attitude.
  kSmoother,
  kDataSheet,  ///< sensor data sheet or a guess: each known within a factor of 1.6
};

/// Assumptions about the trajectory errors.
struct TrajectoryErrorOptions {
  /// Covariance of the errors over time from a smoother. If given, none of the options below is
  /// used.
  std::optional<PoseCovariance> covariance = {};
  /// Stated sigmas of the total error at an epoch: position north, east, down and roll, pitch,
  /// heading. The part of the error that is constant over the flight is estimated.
  Eigen::Vector3d sigma_ned_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_rph_rad = Eigen::Vector3d::Zero();
  SigmaSource sigma_source = SigmaSource::kSmoother;
  /// Start times of the strips, ascending; errors may decorrelate in the turns before them. If
  /// empty, a pause of 5 s between the epochs of the pairs counts as a turn.
  std::vector<double> strip_begin_s = {};
  int max_nodes = 64;  ///< limit of the number of nodes in time; the cost grows with its cube

  /// Throws InvalidConfig naming the option, its value and its bound.
  void Validate() const;
};

/// Covariance of the boresight from time-correlated trajectory errors.
struct CorrelatedErrorCovariance {
  /// Covariance of the boresight, rad^2, in addition to the white part (covariance_scaled_rad2 of
  /// the adjustment).
  Eigen::Matrix3d covariance_rad2 = Eigen::Matrix3d::Zero();
  /// Variances of the other unknowns of the adjustment from the same errors, in its order.
  Eigen::VectorXd other_variances;
  double attitude_ratio = 0.0;  ///< rms of the attitude errors / stated sigma
  double position_ratio = 0.0;  ///< rms of the position errors / stated sigma
  /// Posterior mean of (variance of the attitude error that is constant over the flight) / (stated
  /// variance). It is 0 if a covariance was given, because that covariance already contains the
  /// constant error.
  double constant_share = 0.0;
  /// Correlation time, geometric mean over the fitting processes; 0 if stated or constant.
  double tau_s = 0.0;
  /// Expected chi2 / redundancy of the adjustment, with time-correlated errors of the stated size.
  double expected_ratio = 1.0;
  /// Degrees of freedom of the chi-square approximation: expected_dof chi2 / (expected_ratio
  /// redundancy) is approximately chi-square with expected_dof degrees of freedom. 0 means as many
  /// as the redundancy.
  double expected_dof = 0.0;
  double evidence_nats = 0.0;  ///< log of (likelihood with / without correlated errors)
  int nodes = 0;
};

/// Estimates, from the misclosures of an adjustment, the covariance of its boresight due to
/// time-correlated trajectory errors.
///
/// The formal covariance treats the errors as independent between epochs. If they correlate over a
/// time tau, the pairs of a strip share them, and the boresight varies between flights by much
/// more. A cluster ("sandwich") or HAC estimator sums the scores A^T S w over strips or blocks of
/// time. With three strips there are three pairs of strips, whose scores add up to zero by the
/// normal equations. The estimate then has rank two for three angles, and errors that correlate for
/// longer than a block bias it low. Here the correlation is modelled and its size is estimated (a
/// random effect):
///
///   w_k = A_k dtheta + J_k e(t_i) - J_k e(t_j) + n_k,     n_k ~ N(0, s0^2 S_k^-1)
///
///   e: six Gauss-Markov processes of correlation time tau, with sigma
///      s_p sigma_ned (position) and s_a sigma_rph (roll, pitch, heading)
///
/// The errors are represented at nodes in time and are linear between them. The covariance of a
/// process at the nodes is that of its least-squares fit by such functions. Let H, b, N_e be the
/// sums of J^T S J, J^T S w and J^T S A over the pairs. With dtheta eliminated, H_P = H - N_e N^-1
/// N_e^T, the restricted likelihood of (s_p, s_a, tau), with s0 at its maximum, is
///
///   -2 log L = nu log s0^2 + log det(I + Q^(1/2) H_P Q^(1/2))
///   nu s0^2  = chi2 - b^T (Q^-1 + H_P)^-1 b
///   Q        = K_tau x diag(s_p^2, s_a^2) / s0^2          (x: Kronecker product)
///
/// An error e moves the estimate by -N^-1 N_e^T e, so that
///
///   C(s_p, s_a, tau) = N^-1 N_e^T [ K_tau x diag(s_p^2, s_a^2) ] N_e N^-1.
///
/// The result is the mean of C over the posterior of (s_p, s_a, processes), so parameters that few
/// strips cannot determine widen the result.
///
/// The stated variance is that of the total error at an epoch. A share x of the attitude variance
/// is constant over the flight. It leaves no trace in w because the boresight absorbs it. x s_a^2
/// is reported as constant_share, see ReliableCovariance; the processes have the remaining
/// variance. The prior of x is Jeffreys' prior of a proportion, 1 / (pi sqrt(x (1 - x))). It is
/// represented by its Gauss-Lobatto nodes 0, 1/2, 1 with weights 1 : 2 : 1. The priors of s_a and
/// s_p are log-normal with the mean of the square at 1. They are within a factor of 1.3 (smoother,
/// s_p = s_a) or 1.6 (data sheet, independent).
///
/// All processes have equal prior probability. Positions correlate for 5 or 25 s. Attitudes
/// correlate for 30, 100 or 300 s, or over a strip but not across turns. Their tilt error is fixed
/// in the navigation frame: roll and pitch errors change sign between opposite strips. With
/// data-sheet sigmas, attitude errors fixed in the body frame with correlation times from 3 s to
/// 1000 s are also included. The disagreement between strips weights these processes, as far as it
/// can.
///
/// If the covariance of the errors over time is stated, C is that covariance times a scale s^2. The
/// likelihood is the same, and the prior is that of a smoother. Its epochs are refined once:
/// between two of them the error follows a random-walk bridge.
///
/// Cost: linear in the number of pairs, plus 18 to 52 tridiagonalisations of order 6 x nodes (0.3
/// to 0.6 s at 64 nodes). Throws InvalidConfig for bad options, InvalidInput if the result does not
/// belong to the problem.
CorrelatedErrorCovariance EstimateCorrelatedErrorCovariance(const GaussHelmertProblem& problem,
                                                            const GaussHelmertResult& result,
                                                            BoresightModel model,
                                                            const TrajectoryErrorOptions& options);

/// Returns max(sigma0^2, (chi2 + 10) / (redundancy + 8)). The second term matters only for a
/// handful of observations, whose sigma0 is uncertain. The assumed noise then counts as ten
/// additional observations (mean of the inverse chi-square posterior).
double ReliableVarianceFactor(double sigma0, double chi2, long redundancy);

/// Returns the total covariance of the boresight. It consists of the white part, the part from
/// time-correlated errors, and the constant attitude error, which the boresight absorbs completely:
///
///   C = f N^-1 + C_scatter + C_attitude,      f = ReliableVarianceFactor
///
/// constant_rad2 is C_attitude: constant_share times the stated covariance of the trajectory's
/// attitude in body axes. `result` is a GaussHelmertResult or a PlaneAdjustment.
template <class Result>
Eigen::Matrix3d ReliableCovariance(const Result& result, const CorrelatedErrorCovariance& scatter,
                                   const Eigen::Matrix3d& constant_rad2) {
  return ReliableVarianceFactor(result.sigma0, result.chi2, result.redundancy) *
             result.covariance_apriori_rad2 +
         scatter.covariance_rad2 + constant_rad2;
}

}  // namespace dn
