#pragma once

#include <dn/diagnosis/model_check.h>
#include <dn/solvers/score_test.h>

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "candidate_effects.h"

namespace dn::internal {

// Effects whose evidence is within this of the best one are nearly as likely.
inline constexpr double kEquallyLikelyNats = 3.0;
// Estimates much larger than this many typical sizes are shrunk towards zero, so that components
// that the data do not determine cause no shift.
inline constexpr double kMaxPerTypical = 30.0;

/// Common settings of the tests of effects.
struct ScreenOptions {
  double tests = 1.0;             ///< number of tests of the family; p-values are multiplied by it
  Eigen::VectorXd watched_sigma;  ///< sigmas of the coordinates in JointScore::shift
  bool of_boresight = true;       ///< true: these coordinates are the three angles
};

/// Result of the forward selection of effects.
struct EffectScreen {
  std::vector<EffectCheck> effects;  ///< in the order found
  std::vector<std::size_t> chosen;   ///< index of the candidate of each
  Eigen::VectorXd joint;             ///< joint estimates of all of them, SI, one after another
  JointScore beside;                 ///< the score after they have become unknowns
};

/// Returns the log of the likelihood ratio with and without an effect, averaged over its size:
/// Gaussian with 0.1 to 10 typical sizes.
double LogEvidence(const JointScore& score, const std::vector<Eigen::Index>& components,
                   const Eigen::VectorXd& typical);

/// Returns joint estimates of the components, SI, shrunk towards zero if they are well above
/// kMaxPerTypical typical sizes.
Eigen::VectorXd ShrunkEstimate(const JointScore& score, const std::vector<Eigen::Index>& components,
                               const Eigen::VectorXd& typical);

/// Tests an unmodelled discrepancy after the found effects have become unknowns. `components` are
/// those of the discrepancy in `beside`, after those of the candidates. `excess` is the noise
/// variance over the stated one. Returns nullopt if the unknowns absorb the discrepancy.
std::optional<DiscrepancyCheck> CheckDiscrepancy(const CandidateEffect& departure,
                                                 const JointScore& beside,
                                                 const std::vector<Eigen::Index>& components,
                                                 double excess, const ScreenOptions& options);

/// Selects the likeliest significant effect, up to four times, each time with the selected ones as
/// unknowns. Then estimates all of them jointly. `score` is that of the candidates, in their order.
EffectScreen ScreenEffects(const std::vector<CandidateEffect>& candidates, const JointScore& score,
                           const ScreenOptions& options);

}  // namespace dn::internal
