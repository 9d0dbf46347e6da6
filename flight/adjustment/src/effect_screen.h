#pragma once

#include <dn/calibration/candidate_effects.h>
#include <dn/calibration/model_check.h>
#include <dn/solvers/score_test.h>

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

namespace dn::internal {

// Evidence within which another effect explains the data nearly as well.
inline constexpr double kAsLikelyNats = 3.0;
// Estimates are shrunk towards zero from so many usual sizes on, so that what the data leave open
// moves nothing.
inline constexpr double kLargestPerTypical = 30.0;

/// What effects are screened by.
struct ScreenOptions {
  double tests = 1.0;             ///< of the family: p-values are multiplied by it
  Eigen::VectorXd watched_sigma;  ///< of the coordinates in JointScore::shift
  bool of_boresight = true;       ///< these are the three angles
};

/// The effects that the data show.
struct EffectScreen {
  std::vector<EffectCheck> effects;  ///< in the order found
  std::vector<std::size_t> chosen;   ///< the candidate of each
  Eigen::VectorXd joint;             ///< estimates of all of them together, SI, one after another
  JointScore beside;                 ///< the score once they are among the unknowns
};

/// Log of the likelihood with an effect over that without it, averaged over its size: Gaussian of
/// 0.1 to 10 usual sizes.
double LogEvidence(const JointScore& score, const std::vector<Eigen::Index>& components,
                   const Eigen::VectorXd& typical);

/// Estimates of components together, SI, shrunk towards zero from kLargestPerTypical usual sizes on.
Eigen::VectorXd ShrunkEstimate(const JointScore& score, const std::vector<Eigen::Index>& components,
                               const Eigen::VectorXd& typical);

/// What the data say of a departure beside the effects found: its components in `beside`, which
/// has them after those of the candidates. `excess`: variance of the noise over the stated one; null:
/// nothing of it can be told from the unknowns.
std::optional<DepartureCheck> CheckDeparture(const CandidateEffect& departure,
                                             const JointScore& beside,
                                             const std::vector<Eigen::Index>& components,
                                             double excess, const ScreenOptions& options);

/// Takes the likeliest significant effect, again and again, each beside those before, up to four,
/// and estimates all of them together. `score`: of the candidates, in their order.
EffectScreen ScreenEffects(const std::vector<CandidateEffect>& candidates, const JointScore& score,
                           const ScreenOptions& options);

}  // namespace dn::internal
