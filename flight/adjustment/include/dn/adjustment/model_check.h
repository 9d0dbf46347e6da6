#pragma once

#include <dn/calibration/adjust.h>
#include <dn/calibration/checks.h>
#include <dn/calibration/finding.h>
#include <dn/calibration/result.h>
#include <dn/solvers/marginals.h>

#include <vector>

namespace dn {

/// Whether the data of an adjusted flight are those that the assumed model would produce.
struct ModelCheck {
  bool of_boresight = false;  ///< what an effect moves is the boresight; else poses
  std::vector<GroupCheck> groups;
  std::vector<CommonErrorCheck> common_errors;
  std::vector<EffectCheck> effects;        ///< the significant ones, in the order found
  std::vector<DepartureCheck> departures;  ///< without a name, tested beside those
  std::vector<UnseenEffect> unseen;        ///< what could hide, the most harmful first
  std::vector<RivalCheck> rivals;          ///< of estimated unknowns
  std::vector<PriorCheck> priors;
  /// Estimates of the adjustment where they are among its unknowns, of the screening where it has
  /// found the clock off, else by the scores of the effects, offset and drift together.
  Clocks clocks;
  double gnss_clock_damage = 0.0;      ///< of Adjustment::gnss_clock, as EffectCheck::damage
  double sigma0_beside_effects = 1.0;  ///< sigma0 with those among the unknowns, to first order
  double p_value = 1.0;                ///< smallest of all, for the family
  std::vector<Finding> findings;       ///< those that contradict first

  double SmallestPValue() const;  ///< of all tests; 1 without any
  bool contradicted() const;
};

/// Tests an adjusted flight, without solving it again:
///
///   groups         r^T r of a group is a quadratic form of the errors with the mean tr(M_gg) (the
///                  sum of redundancy numbers) and the variance 2 tr(M_gg^2);
///   common errors  the same for sums of residuals over windows of time, and over pairs of strips;
///   effects        score tests of CandidateEffects, the likeliest first, each beside those before
///                  (the ratio of likelihoods over sizes around the usual one), with the move of
///                  the boresight that its estimate explains;
///   departures     score tests of laser vectors that differ by scan angle or by strip, beside the
///                  effects found: what is significant there has no name;
///   unseen         effects whose usual size is below the minimal detectable one and moves a watched
///                  unknown by more than its sigma: by geometry alone, no measured value counts;
///   rivals         score tests with a candidate in the place of an unknown that is estimated: another
///                  cause of what that explains, and where it would put the boresight;
///   priors         predicted residual of each stated prior (PredictFactor);
///   shares of pairs and GNSS epochs that were left out, size of the boresight, sigma0.
///
/// tr(M_gg^2) and the moments of the sums over windows are those of 32 samples of M e, e ~ N(0, I),
/// of one fixed seed. p-values follow from the chi-square distribution of the same two moments.
///
/// A finding contradicts when it is significant at 0.001 for the family and moves the boresight
/// (without pairs: an attitude or a position) by more than its sigma, or has no name, when a group has
/// more than twice its variance, sigma0 exceeds 3, more than 30 % of the pairs or 10 % of the GNSS epochs
/// were left out, a boresight angle exceeds 15 deg, the body flies on its back, or the
/// configuration says that a diagnosis found what it does not model.
///
/// `marginals` must be of the adjusted network with its selected inverse, `trajectory` what
/// ExtractTrajectory gave for both. CheckFit says the same of any network, as far as it can be said
/// without knowing what it is of.
ModelCheck CheckModel(const Adjustment& adjustment, const Marginals& marginals,
                      const TrajectoryResult& trajectory, int threads = 1);

/// Sets the verdict to contradicted where the check says so, to not observable where an estimated
/// unknown has a rival that moves the boresight by more than its sigma, and puts what it found before
/// the other reasons. Of a kind that the check has too, the check's are told.
void Assess(const ModelCheck& check, BoresightResult* boresight);

}  // namespace dn
