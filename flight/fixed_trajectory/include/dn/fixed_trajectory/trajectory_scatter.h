#pragma once

#include <dn/solvers/gauss_helmert.h>

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace dn {

/// Joint covariance of the errors of a trajectory at some epochs, between which they are linear in
/// time.
struct PoseCovariance {
  std::vector<double> t_s;  ///< increasing
  std::vector<int> strip;   ///< of each epoch, not decreasing; nothing is said between two strips
  /// Six rows per epoch: position in map axes (m), attitude as a rotation vector in body axes (rad,
  /// q_mb Exp(d)).
  Eigen::MatrixXd covariance;

  /// Throws InvalidConfig naming what does not fit.
  void Validate() const;
};

/// Who states the sigmas of a trajectory.
enum class StatedBy {
  kSmoother,   ///< of this flight: known within a factor of 1.3, position and attitude alike
  kDataSheet,  ///< of the sensor, or a guess: each within a factor of 1.6
};

/// What is known of the errors of a trajectory.
struct TrajectoryScatterOptions {
  /// Where a smoother states how its errors correlate: nothing else below is used.
  std::optional<PoseCovariance> covariance = {};
  /// What the trajectory states about itself: sigma of position north, east, down and of roll,
  /// pitch, heading, of the whole error at an epoch. How much of it is constant over the flight is
  /// estimated.
  Eigen::Vector3d sigma_ned_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_rph_rad = Eigen::Vector3d::Zero();
  StatedBy stated_by = StatedBy::kSmoother;
  /// Begins of the strips, ascending: errors may end in the turns before them. If empty, a pause
  /// of 5 s among the epochs of the pairs is a turn.
  std::vector<double> strip_begin_s = {};
  int max_nodes = 64;  ///< in time; the cost grows with its cube

  /// Throws InvalidConfig naming the option, its value and its bound.
  void Validate() const;
};

/// How the time-correlated errors of the trajectory scatter the boresight.
struct TrajectoryScatter {
  /// Of the boresight, rad^2: beyond the white part (covariance_scaled_rad2 of the adjustment).
  Eigen::Matrix3d covariance_rad2 = Eigen::Matrix3d::Zero();
  double attitude_ratio = 0.0;  ///< rms of the attitude errors / the stated sigma
  double position_ratio = 0.0;  ///< the same of the positions
  /// Variance of an attitude error constant over the flight / the stated variance: posterior mean;
  /// 0 with a covariance, which holds it.
  double constant_share = 0.0;
  double tau_s = 0.0;  ///< correlation time, geometric mean over what fits; 0: stated, or constant
  /// Expected chi2 / redundancy of the adjustment, with errors of the stated size that last.
  double expected_ratio = 1.0;
  /// chi2 / (expected_ratio redundancy) then spreads about as a chi-square of so many degrees of
  /// freedom over their number; 0: as many as the redundancy.
  double expected_dof = 0.0;
  double evidence_nats = 0.0;  ///< log of (likelihood with / without correlated errors)
  int nodes = 0;
};

/// Estimates, from the misclosures of an adjustment, the covariance that errors of the trajectory
/// with a correlation in time give to its boresight.
///
/// The formal covariance takes the errors as new at every epoch. If they last for tau, the pairs
/// of a strip share them, and the boresight scatters from flight to flight by much more. A cluster
/// ("sandwich") or HAC estimator sums the scores A^T S w over strips or blocks of time: with three
/// strips there are three pairs of strips, whose scores add up to zero by the normal equations, so
/// the estimate has rank two for three angles, and it is biased low by whatever lasts longer than
/// a block. Here the correlation is modelled and its size is estimated (a random effect):
///
///   w_k = A_k dtheta + J_k e(t_i) - J_k e(t_j) + n_k,     n_k ~ N(0, s0^2 S_k^-1)
///
///   e: six Gauss-Markov processes of correlation time tau, with sigma
///      s_p sigma_ned (position) and s_a sigma_rph (roll, pitch, heading)
///
/// at nodes in time, linear between them; a process has the covariance there of its least-squares
/// fit by such functions. With H, b, N_e the sums of J^T S J, J^T S w and J^T S A over the pairs,
/// and dtheta eliminated, H_P = H - N_e N^-1 N_e^T, the restricted likelihood of (s_p, s_a, tau),
/// with s0 at its maximum, is
///
///   -2 log L = nu log s0^2 + log det(I + Q^(1/2) H_P Q^(1/2))
///   nu s0^2  = chi2 - b^T (Q^-1 + H_P)^-1 b
///   Q        = K_tau x diag(s_p^2, s_a^2) / s0^2          (x: Kronecker product)
///
/// An error e moves the estimate by -N^-1 N_e^T e, so that
///
///   C(s_p, s_a, tau) = N^-1 N_e^T [ K_tau x diag(s_p^2, s_a^2) ] N_e N^-1.
///
/// The result is the mean of C over the posterior of (s_p, s_a, processes): what few strips cannot
/// tell widens it instead of being ignored.
///
/// The stated variance is that of the whole error at an epoch. A share x of the attitude's is
/// constant over the flight: it leaves no trace in w (the boresight absorbs it), and x s_a^2 is
/// reported as constant_share, see ReliableCovariance; the processes have the rest. Prior of x:
/// Jeffreys' of a proportion, 1 / (pi sqrt(x (1 - x))), by its Gauss-Lobatto nodes 0, 1/2, 1 with
/// weights 1 : 2 : 1. Prior of s_a and s_p: log-normal within a factor of 1.3 (a smoother's;
/// s_p = s_a) or 1.6 (a data sheet's; each by itself), with the mean of the square at 1.
/// Processes, equally likely: positions correlate for 5 or 25 s; attitudes for 30, 100 or 300 s,
/// with the tilt fixed to the navigation frame (roll and pitch errors change sign from a strip to
/// the opposite one), or over a strip and not beyond its turns; by a data sheet also any from 3 s
/// to 1000 s, fixed to the body. How the strips disagree decides between these, as far as it can.
///
/// Where the covariance of the errors over time is stated, C is that of the stated errors, times
/// their scale s^2 by the same likelihood and the prior of a smoother; nothing is guessed. Its
/// epochs are refined once: between two of them an error bends like a random walk.
///
/// Cost: linear in the pairs, and 18 to 52 tridiagonalisations of order 6 x nodes (0.3 to
/// 0.6 s at 64 nodes).
/// Throws InvalidConfig for bad options, InvalidInput when the result does not belong to the
/// problem.
TrajectoryScatter EstimateTrajectoryScatter(const GaussHelmertProblem& problem,
                                            const GaussHelmertResult& result, BoresightModel model,
                                            const TrajectoryScatterOptions& options);

/// max(sigma0^2, (chi2 + 10) / (redundancy + 8)): sigma0^2 but for a handful of
/// observations, whose sigma0 says little: there the assumed noise counts as ten observations of
/// its own (mean of the inverse chi-square posterior).
double ReliableVarianceFactor(double sigma0, double chi2, long redundancy);

/// What may be relied on: white part, scatter by correlated errors, and the attitude error that is
/// constant over the flight, which the boresight absorbs without a trace,
///
///   C = f N^-1 + C_scatter + C_attitude,      f = ReliableVarianceFactor
///
/// constant_rad2: C_attitude, constant_share times the covariance of the trajectory's attitude in
/// body axes by its own account.
Eigen::Matrix3d ReliableCovariance(const GaussHelmertResult& result,
                                   const TrajectoryScatter& scatter,
                                   const Eigen::Matrix3d& constant_rad2);

}  // namespace dn
