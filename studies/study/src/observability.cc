#include "observability.h"

#include <dn/effects/effect_table.h>
#include <dn/files/scanners.h>

#include <cmath>

namespace dn {
namespace {

constexpr double kInseparable = 0.999;
constexpr double kUsualSizes = 100.0;
constexpr Eigen::Index kBoresightAngles = 3;

/// Returns the sigma above which a component of an unknown counts as undetermined, in its unit.
double LargestSigma(const EffectComponent& component) { return kUsualSizes * component.typical; }

/// Calls visit(index in the joint covariance, entry, effect, index of the component) for each
/// component.
template <class Visit>
void ForEachComponent(const FlightConfig& config, const Visit& visit) {
  Eigen::Index i = kBoresightAngles;
  for (const EstimateEntry& entry : config.estimate) {
    const EffectSpec* effect = FindEffect(entry.unknown);
    if (effect == nullptr) {  // a boresight; that of the first scanner is the first of all
      if (!entry.scanner.empty() && FindScanner(config, entry.unknown) > 0) i += kBoresightAngles;
      continue;
    }
    for (std::size_t k = 0; k < effect->components.size(); ++k, ++i) visit(i, entry, *effect, k);
  }
}

}  // namespace

std::vector<StudyUnknown> ListUnknowns(const JointCovariance& joint, const FlightConfig& config) {
  std::vector<StudyUnknown> unknowns;
  ForEachComponent(config, [&](Eigen::Index i, const EstimateEntry& entry, const EffectSpec& effect,
                               std::size_t k) {
    const JointUnknown& unknown = joint.unknowns[static_cast<std::size_t>(i)];
    if (k == 0) unknowns.push_back({entry.unknown, unknown.unit, {}, {}});
    unknowns.back().components.push_back(effect.components[k].name);
    unknowns.back().sigma.push_back(joint.sigma(i) * unknown.per_si);
  });
  return unknowns;
}

std::vector<Unobservable> FindUnobservable(const JointCovariance& joint,
                                           const FlightConfig& config) {
  std::vector<Unobservable> found;
  ForEachComponent(
      config, [&](Eigen::Index i, const EstimateEntry&, const EffectSpec& effect, std::size_t k) {
        const JointUnknown& unknown = joint.unknowns[static_cast<std::size_t>(i)];
        const double sigma = joint.sigma(i) * unknown.per_si;
        if (sigma > LargestSigma(effect.components[k])) {
          found.push_back({unknown.name, "", sigma, unknown.unit});
        }
        for (Eigen::Index j = 0; j < joint.covariance.rows(); ++j) {
          const JointUnknown& partner = joint.unknowns[static_cast<std::size_t>(j)];
          const bool told_before = j >= kBoresightAngles && j < i;
          if (j == i || told_before || !partner.calibration) continue;
          if (std::abs(joint.correlation(i, j)) <= kInseparable) continue;
          found.push_back({unknown.name, partner.name, joint.correlation(i, j), unknown.unit});
        }
      });
  return found;
}

}  // namespace dn
