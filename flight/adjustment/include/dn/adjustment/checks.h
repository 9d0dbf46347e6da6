#pragma once

#include <dn/eigen_alignment.h>

#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// Residuals of one kind compared with their redundancy. The p-values of all checks are
/// family-wise: they are multiplied by the number of tests of the model check.
struct GroupCheck {
  std::string name;                 ///< "lidar p2p", "inertial gyro", "gnss position east" ...
  long observations = 0;            ///< number of residuals
  double redundancy = 0.0;          ///< sum of their redundancy numbers
  double variance_ratio = 1.0;      ///< sum of squares / redundancy
  double ratio_with_effects = 1.0;  ///< the same if the found effects were estimated
  double p_value = 1.0;             ///< of a ratio this far from 1, two-sided
  double worst_t_s = 0.0;
  double worst_standardised = 0.0;  ///< residual / root of its redundancy number
  bool isolated = false;            ///< one wrong measurement explains the misfit of the group
  /// The reported covariance contains noise of the size that the residuals show, and their ratio is
  /// not significantly above the largest one that is tolerated.
  bool covered = false;
  /// Not significant any more if the noise of other sensors is as large as their residuals show.
  bool explained = false;
};

/// Test for errors that residuals share: sum, over time windows, of the squared sum of the
/// residuals in the window.
struct CommonErrorCheck {
  std::string name;      ///< "gnss position, over 60 s" ...
  std::string group;     ///< group of the residuals
  std::string worst;     ///< of strip pairs: the pair that disagrees most, if significant
  double ratio = 1.0;    ///< that sum over its expectation
  double p_value = 1.0;  ///< of a ratio this large, one-sided
  double sigma = 0.0;    ///< size of the common error, in sigmas of one residual; 0 if none
  /// Largest shift of a watched unknown by such errors, in its sigmas.
  double max_shift_sigmas = 0.0;
  /// Nats, for a common error of the likeliest size against no common error.
  double log_evidence = 0.0;
  /// No longer significant if the found effects are estimated, and the noise of other sensors is as
  /// large as their residuals show.
  bool explained = false;
  /// The reported covariance contains errors that residuals of the group share. The rest is not
  /// significant, or shifts no watched unknown by more than its sigma.
  bool covered = false;
};

/// Evidence for an effect, with its estimate.
struct EffectEvidence {
  /// Nats, against its absence, averaged over sizes around the typical one.
  double log_evidence = 0.0;
  double p_value = 1.0;
  /// Components of a fixed effect, a ratio, or the sigmas of a process and its time constant.
  Eigen::VectorXd estimate = {};
  Eigen::VectorXd sigma = {};                               ///< NaN: undetermined
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();  ///< shift of the boresight
  /// Largest estimate of a component in standard deviations of its prior; absent without a prior
  /// (UnmodelledPrior).
  std::optional<double> prior_sigmas = {};

  /// An effect beyond this many standard deviations of its prior is a fault, not a tolerance.
  static constexpr double kFaultPriorSigmas = 4.0;
  bool within_prior() const { return prior_sigmas && *prior_sigmas <= kFaultPriorSigmas; }
};

/// An effect that is significant in the data and not estimated by the network. Score test, first
/// order, jointly with the other found effects.
struct EffectCheck : EffectEvidence {
  std::string name;
  std::string unit;  ///< unit of the estimate
  std::string remedy;
  double max_shift_sigmas = 0.0;  ///< largest shift of a watched unknown, in its sigmas
  std::vector<std::string> inseparable_from;
};

/// An unmodelled discrepancy: a deviation of the data from the model that no effect of the table
/// describes. It is a score test that is made after the found effects are estimated. Its noise
/// level is the one that the pairs show, if that is above the stated one.
struct DiscrepancyCheck {
  std::string name;  ///< "laser vectors by scan angle" ...
  double statistic = 0.0;
  int dof = 0;
  double p_value = 1.0;
  /// Shift of the boresight by the estimated discrepancy.
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();
  double max_shift_sigmas = 0.0;  ///< largest shift of a watched unknown, in its sigmas
};

/// An undetectable effect: its typical size is below its minimal detectable bias (MDB), but shifts
/// a watched unknown by more than the unknown's sigma. Only the component with the largest shift is
/// given; each component is taken by itself.
struct UndetectableEffect {
  std::string name;
  std::string component;  ///< "x", "east"; empty if the effect has one component
  std::string unit;       ///< unit of both sizes
  double usual = 0.0;     ///< typical size: one prior sigma
  /// MDB (Baarda, see OutlierTest), first order; infinite if no size is detectable.
  double minimal_detectable = 0.0;
  /// Shift of the boresight at the size `usual`.
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();
  /// Largest shift of a watched unknown at that size, in its sigmas.
  double max_shift_sigmas = 0.0;
};

/// A competing effect: it explains the data as well as an estimated unknown. If several do, it is
/// the one that shifts the watched unknowns farthest when it replaces the unknown.
struct CompetingEffectCheck {
  std::string unknown, competing_effect;
  double log_evidence = 0.0;  ///< nats, of the competing effect against the unknown
  /// Boresight with the competing effect minus boresight with the unknown.
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();
  double max_shift_sigmas = 0.0;  ///< largest shift of a watched unknown, in its sigmas
};

/// A run of GNSS positions that the adjustment left out because they contradict the inertial data.
/// Its shape may tell which sensor is wrong: an offset with sharp ends, or white noise, is of GNSS.
struct GnssRunCheck {
  double t0_s = 0.0, t1_s = 0.0;  ///< first and last of the positions
  long positions = 0;
  /// Nats, for an error of GNSS against an error of the inertial data.
  double log_gnss_over_inertial = 0.0;
  /// Shift of the boresight if the positions were used.
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();
  double max_shift_sigmas = 0.0;  ///< largest shift of a watched unknown, in its sigmas

  /// One of the two must be likelier by this factor to be decided for.
  static constexpr double kDecisiveRatio = 1000.0;
  bool is_gnss() const { return log_gnss_over_inertial >= std::log(kDecisiveRatio); }
  /// Also true for an error of GNSS that is as smooth as one of the inertial data.
  bool is_inertial() const { return log_gnss_over_inertial <= -std::log(kDecisiveRatio); }
};

/// Test of the stated prior of an unknown against the prediction from all other data.
struct PriorCheck {
  std::string unknown;
  double statistic = 0.0;
  int dof = 0;
  double p_value = 1.0;
};

}  // namespace dn
