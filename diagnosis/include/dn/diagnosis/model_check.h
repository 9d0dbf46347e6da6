#pragma once

#include <dn/adjustment/adjust.h>
#include <dn/adjustment/checks.h>
#include <dn/adjustment/control_checks.h>
#include <dn/adjustment/finding.h>
#include <dn/adjustment/gauss_helmert_flight.h>
#include <dn/adjustment/plane_flight.h>
#include <dn/adjustment/result.h>
#include <dn/diagnosis/effect_posterior.h>
#include <dn/solvers/marginals.h>

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// Change of a node of the trajectory by effects that the model leaves out.
struct NodeChange {
  double t_s = 0.0;
  Eigen::Vector3d position_m;                        ///< correction, map axes
  Eigen::Vector3d velocity_mps;                      ///< correction, map axes
  Eigen::Vector3d attitude_rad;                      ///< right rotation: q_mb' = q_mb Exp(attitude)
  Eigen::Vector3d gyro_bias_radps, accel_bias_mps2;  ///< corrections of the total biases
  /// Variances added: east, north, up; roll, pitch, heading.
  Eigen::Vector3d velocity_variance_enu, rph_variance_rad2;
  Eigen::Matrix3d position_covariance_m2, velocity_covariance;  ///< added, map axes
  Eigen::Matrix3d gyro_bias_covariance, accel_bias_covariance;  ///< added, (rad/s)^2, (m/s^2)^2
  /// G with the joint covariance G_i G_j^T that is added to the poses of nodes i and j: position
  /// east, north, up (m), attitude in body (rad).
  Eigen::Matrix<double, 6, Eigen::Dynamic> pose_root;

  /// Applies the corrections of position, velocity and attitude to a pose.
  void MovePose(MapPose* pose) const;
};

/// Effects that the model leaves out, as unknowns with their priors: the change of the results that
/// this makes, to first order.
///
///   e = -(A + D^-1)^-1 s,   x' = x - S e,   C' = C + S (A + D^-1)^-1 S^T
///
/// s, A and S are the score, the information and the shift of the effects (JointScore), and D is
/// their prior covariance (UnmodelledPrior). A process of the GNSS positions has one D per size and
/// time constant. With it, e and C' are mean and covariance over the posterior of both.
struct UnmodelledEffects {
  /// Change of an estimated effect: the correction of its value, and the variance added, SI.
  struct UnknownChange {
    std::string name;
    Eigen::VectorXd value, variance;
  };

  /// Left rotation of the boresight, and the covariance added; zero without boresight.
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_rad2 = Eigen::Matrix3d::Zero();
  /// The part of covariance_rad2 that is from noise beyond the stated one, not from effects.
  Eigen::Matrix3d noise_covariance_rad2 = Eigen::Matrix3d::Zero();
  std::vector<UnknownChange> unknowns;            ///< those of `estimate`, and of beams
  std::vector<EffectContribution> contributions;  ///< the largest first
  /// Change of MountingUnknowns in a flight with several scanners, and the covariance added. The
  /// contributions are those to the boresight of each scanner.
  Eigen::VectorXd mountings;
  Eigen::MatrixXd mountings_covariance;
  std::vector<std::vector<EffectContribution>> scanner_contributions;
  std::vector<NodeChange> nodes;  ///< of a network, in the order of its nodes
  EffectPosterior posterior;      ///< of a network with a boresight
  /// Whether the size of the time-correlated error of the GNSS positions (gnss.processes: auto) is
  /// one that its prior expects; absent without it.
  std::optional<bool> gnss_process_usual;
};

/// Results of the tests of whether the data of an adjusted flight agree with the assumed model.
struct ModelCheck {
  bool of_boresight = false;  ///< true: the watched unknowns are the boresight; otherwise poses
  /// Effects that the model leaves out; absent if their prior rules all of them out. All tests are
  /// those of the model with these effects as unknowns.
  std::optional<UnmodelledEffects> unmodelled;
  std::vector<GroupCheck> groups;
  std::vector<CommonErrorCheck> common_errors;
  std::vector<EffectCheck> effects;  ///< the significant ones, in the order found
  /// Unmodelled discrepancies, tested jointly with `effects`.
  std::vector<DiscrepancyCheck> discrepancies;
  std::vector<UndetectableEffect> undetectable;         ///< largest shift first
  std::vector<CompetingEffectCheck> competing_effects;  ///< competing effects of estimated unknowns
  std::vector<PriorCheck> priors;
  std::vector<GnssRunCheck> gnss_runs;  ///< GNSS positions that were left out, in time
  std::optional<ControlCheck> control;  ///< of a network with control points
  /// Clock errors. They are from the GNSS screening if it found the clock off, else from the
  /// adjustment if it estimates them. Otherwise offset and drift are estimated jointly from the
  /// scores of their effects.
  Clocks clocks;
  double gnss_clock_shift = 0.0;         ///< of gnss_clock, like EffectCheck::max_shift_sigmas
  bool gnss_clock_within_prior = false;  ///< the same, like EffectEvidence::within_prior
  double sigma0_with_effects = 1.0;      ///< sigma0 if `effects` were estimated, first order
  /// Number of independent tests whose smallest p-value has the distribution of that of all tests;
  /// 0 if it was not estimated.
  double effective_tests = 0.0;
  /// Probability of a smallest p-value as small as that of this flight if the model holds. It is
  /// uniform then for a network; for other methods it is the smallest family-wise p-value.
  double p_value = 1.0;
  /// The contradicting ones first; of these, and of the others, the first of each cause.
  std::vector<Finding> findings;

  double SmallestPValue() const;  ///< family-wise, of all tests; 1 if there are none
  bool contradicted() const;
};

/// Tests the model of an adjusted flight without solving it again:
///
///   groups         r^T r of a group is a quadratic form of the errors with the mean tr(M_gg) (the
///                  sum of redundancy numbers) and the variance 2 tr(M_gg^2).
///   common errors  the same for sums of residuals over time windows and over strip pairs.
///   effects        forward selection by score tests of all effects that are not estimated: the
///                  likeliest becomes an unknown, and the others are tested again. The evidence is
///                  the likelihood ratio, averaged over sizes around the typical one. Each effect
///                  has the shift of the boresight that its estimate predicts.
///   discrepancies  score tests of laser vectors that differ by scan angle or by strip, after the
///                  found effects are estimated: significant ones are unmodelled discrepancies.
///   undetectable   effects whose typical size is below the minimal detectable bias, but shifts a
///                  watched unknown by more than its sigma. They depend on the geometry only, not
///                  on the measured values.
///   competing      score tests with another effect instead of an estimated unknown, and the
///                  boresight that it would give.
///   priors         predicted residual of each stated prior (PredictFactor).
///   GNSS runs      likelihood of an error of GNSS (an offset, noise of another size) against that
///                  of an error of the inertial data, for runs of at least 8 rejected positions.
///   others         shares of rejected pairs and GNSS epochs, size of the boresight, sigma0.
///
/// The p-values of single tests are multiplied by the number of tests (Bonferroni), so that their
/// level is kept for any dependence. The p-value of the flight is 1 - (1 - p)^m with the smallest
/// raw p. The effective number of tests m is the maximum likelihood estimate from the smallest p of
/// replicates. For groups and common errors these are the 32 samples of residuals, for the scores
/// 400 draws of N(0, A). Each prior adds one test.
///
/// tr(M_gg^2) and the moments of the sums over windows are estimated from 32 samples of M e, e ~
/// N(0, I), with a fixed seed. The p-values are those of a chi-square distribution with the same
/// mean and variance.
///
/// If a flight has a boresight and unmodelled effects, its noise is estimated from the residuals
/// with all effects. Each channel has a variance, pairs one for each axis, and so have the errors
/// that neighbouring pairs share. What exceeds the stated noise is part of the covariance
/// (UnmodelledEffects::noise_covariance_rad2), and tests are repeated with it:
///   - Found effects: the covariance of their scores contains the noise. The statistic of an effect
///     of the lidar or of GNSS is also divided by the largest growth of errors that pairs or
///     positions share. Effects that are not significant any more are dropped.
///   - Groups and common errors: the samples contain the noise of the other channels. A trajectory
///     that follows errors of the pairs has larger inertial residuals, and these are then
///     `explained`. Channels whose redundancy is below half the number of their residuals show the
///     noise of other sensors more than their own, and add none.
///   - Groups and common errors that the covariance allows for are `covered`.
///
/// A finding contradicts the model in these cases:
///   - an effect with a prior (UnmodelledPrior) is significant at the family-wise level 0.001 and
///     exceeds four standard deviations of its prior;
///   - another effect, or a common error that is neither explained nor covered, is significant at
///     the family-wise level 0.001 and shifts the boresight (without pairs: an attitude or a
///     position) by more than its sigma;
///   - an unmodelled discrepancy is significant at that level, or a stated prior is contradicted;
///   - a group that is neither explained nor covered has more than twice its variance after the
///     found effects, one measurement explains the misfit of its group, or sigma0 exceeds 3;
///   - more than 30 % of the pairs or 10 % of the GNSS epochs were rejected;
///   - a run of rejected GNSS positions has the shape of an error of the inertial data, or it may
///     have it and shifts a watched unknown by more than its sigma if it is used;
///   - the control is shifted at that level, or more than a third of it was rejected;
///   - a boresight angle exceeds 15 deg, or the body is upside down;
///   - the GNSS clock error has no prior, or exceeds four standard deviations of it, and shifts a
///     watched unknown by more than its sigma;
///   - the INS/GNSS adjustment finds another lever arm of GNSS, unless lever arms have a prior and
///     no effect of GNSS was found;
///   - the configuration says that a diagnosis found an unmodelled discrepancy.
///
/// `marginals` must be of the adjusted network, with its selected inverse. `trajectory` must be the
/// result of ExtractTrajectory for both. CheckFit makes the tests that apply to any network.
ModelCheck CheckModel(const Adjustment& adjustment, const Marginals& marginals,
                      const TrajectoryResult& trajectory, int threads = 1);

/// Tests the model of a Gauss-Helmert adjustment by its misclosures. Contradictions are
///   - an effect of the lidar (time tags, lever arm, ranges, scan angles) that shifts the boresight
///     by more than its sigma, or an unmodelled discrepancy;
///   - misclosures with more than twice their stated variance after the found effects;
///   - more than 30 % of the pairs as outliers, or a stated prior that contradicts the pairs;
///   - an angle above 15 deg.
///
/// Effects are tested jointly with time-correlated errors of the trajectory, of the stated size or
/// larger. Effects that resemble such errors stay undetectable. They are late tags in quiet flight,
/// a lever arm in strips at one height, a mount that moves, and a constant attitude error.
ModelCheck CheckModel(const Flight& flight, const GaussHelmertCalibration& calibration);

/// Tests the model of a plane adjustment. Contradictions are points with more than twice their
/// stated variance about the planes, and an angle above 15 deg. Errors of the lidar (time tags,
/// lever arm, ranges, scan angles) are not tested.
ModelCheck CheckModel(const Flight& flight, const PlaneCalibration& calibration);

/// Tests the model of a calibration (CheckModel), and adds the findings to its boresight (Assess).
ModelCheck AssessModel(const Flight& flight, GaussHelmertCalibration* calibration);
ModelCheck AssessModel(const Flight& flight, PlaneCalibration* calibration);

/// Returns "consistent" or "contradicted", for a trajectory without boresight.
const char* Word(const ModelCheck& check);

/// Takes the effects that the model leaves out into angles, covariance and contributions of a
/// boresight of the pure model. Sets the verdict to not observable if AssessLargestSigma does.
void AddUnmodelled(const UnmodelledEffects& effects, BoresightResult* boresight);

/// Adds the findings of the check to the verdict and the reasons of a boresight that contains the
/// unmodelled effects (AddUnmodelled).
void AddFindings(const ModelCheck& check, BoresightResult* boresight);

/// Takes the unmodelled effects of the check into a boresight of the pure model (AddUnmodelled).
/// Adds the findings of the check to the reasons of the boresight, before the other reasons. A fact
/// of the check replaces reasons of the same type. Sets the verdict to contradicted if the check
/// contradicts. Otherwise sets it to not observable if a competing effect of an estimated unknown
/// shifts the boresight by more than its sigma.
void Assess(const ModelCheck& check, BoresightResult* boresight);

}  // namespace dn
