#include "undetectable_effects.h"

#include <dn/effects/effect_table.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "detectability.h"

namespace dn::internal {
namespace {

// The covariance of an unknown does not cover an error above this many of its sigmas.
constexpr double kHarmfulSigmas = 1.0;

std::string EffectComponentName(const CandidateEffect& candidate, Eigen::Index component) {
  const EffectSpec* spec = FindEffect(candidate.name);
  if (candidate.typical.size() == 1 || spec == nullptr) return "";
  return spec->components[static_cast<std::size_t>(component)].name;
}

/// Returns the undetectable component with the largest shift; nullopt if all components are
/// detectable or harmless.
std::optional<UndetectableEffect> Unseen(const CandidateEffect& candidate,
                                         const std::vector<Eigen::Index>& components,
                                         const JointScore& score, const ScreenOptions& options) {
  std::optional<UndetectableEffect> worst;
  for (Eigen::Index k = 0; k < candidate.typical.size(); ++k) {
    const Eigen::Index c = components[static_cast<std::size_t>(k)];
    const double usual = candidate.typical[k];
    const double detectable = MinimalDetectableBias(score.A(c, c), score.signature2[c]);
    const Eigen::VectorXd move = usual * score.shift.col(c);
    const double max_shift_sigmas = move.cwiseQuotient(options.watched_sigma).cwiseAbs().maxCoeff();
    if (detectable <= usual || max_shift_sigmas <= kHarmfulSigmas) continue;
    if (worst && max_shift_sigmas <= worst->max_shift_sigmas) continue;
    worst = UndetectableEffect{
        candidate.name,           EffectComponentName(candidate, k), candidate.unit,
        candidate.per_si * usual, candidate.per_si * detectable,     Eigen::Vector3d::Zero(),
        max_shift_sigmas};
    if (options.of_boresight) worst->boresight_rad = move;
  }
  return worst;
}

}  // namespace

std::vector<UndetectableEffect> FindUndetectable(const std::vector<CandidateEffect>& candidates,
                                                 const JointScore& score,
                                                 const ScreenOptions& options) {
  std::vector<UndetectableEffect> found;
  for (std::size_t k = 0; k < candidates.size(); ++k) {
    std::optional<UndetectableEffect> unseen =
        Unseen(candidates[k], score.Components(k), score, options);
    if (unseen) found.push_back(std::move(*unseen));
  }
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
    return a.max_shift_sigmas > b.max_shift_sigmas;
  });
  std::vector<UndetectableEffect> by_name;
  for (UndetectableEffect& effect : found) {
    const bool known =
        std::any_of(by_name.begin(), by_name.end(),
                    [&](const UndetectableEffect& other) { return other.name == effect.name; });
    if (!known) by_name.push_back(std::move(effect));
  }
  return by_name;
}

}  // namespace dn::internal
