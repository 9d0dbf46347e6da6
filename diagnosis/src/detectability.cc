#include "detectability.h"

#include <dn/solvers/fit_check.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

namespace dn::diagnosis_internal {
namespace {

// The covariance of an unknown does not cover an error above this many of its sigmas.
constexpr double kHarmfulSigmas = 1.0;

std::string EffectComponentName(const Hypothesis& hypothesis, Eigen::Index component) {
  if (hypothesis.typical.size() == 1) return "";
  return EffectRow(*hypothesis.id).components[static_cast<std::size_t>(component)].name;
}

/// Returns the undetectable component with the largest shift; nullopt if all components are
/// detectable or harmless.
std::optional<UndetectableEffect> WorstComponent(const Hypothesis& hypothesis,
                                                 const JointScore& score,
                                                 const TestFamily& family) {
  const Eigen::VectorXd detectable = MinimalDetectableBiases(hypothesis, score);
  const Eigen::MatrixXd shift = SelectShift(hypothesis, score) * hypothesis.typical.asDiagonal();
  std::optional<UndetectableEffect> worst;
  for (Eigen::Index k = 0; k < hypothesis.typical.size(); ++k) {
    const double usual = hypothesis.typical[k];
    const double max_shift_sigmas = family.InSigmas(shift.col(k));
    if (detectable[k] <= usual || max_shift_sigmas <= kHarmfulSigmas) continue;
    if (worst && max_shift_sigmas <= worst->max_shift_sigmas) continue;
    worst = UndetectableEffect{hypothesis.name,
                               EffectComponentName(hypothesis, k),
                               hypothesis.unit,
                               hypothesis.per_si * usual,
                               hypothesis.per_si * detectable[k],
                               family.BoresightShift(shift.col(k)),
                               max_shift_sigmas};
  }
  return worst;
}

}  // namespace

double MinimalDetectableBias(double information, double signature2) {
  if (!(information > kAbsorbedShare * signature2)) return std::numeric_limits<double>::infinity();
  return OutlierTest().NonCentrality() / std::sqrt(information);
}

Eigen::VectorXd MinimalDetectableBiases(const Hypothesis& hypothesis, const JointScore& score) {
  return SelectInformation(hypothesis, score)
      .diagonal()
      .binaryExpr(SelectSignature(hypothesis, score), &MinimalDetectableBias);
}

std::vector<UndetectableEffect> FindUndetectable(const Library& library, const JointScore& score,
                                                 const TestFamily& family,
                                                 const UnmodelledPrior& prior) {
  std::vector<UndetectableEffect> found;
  for (const Hypothesis& hypothesis : library.hypotheses) {
    if (!hypothesis.id) continue;
    const bool fixed = EffectRow(*hypothesis.id).fixed();
    if (fixed && !prior.Sigma(*hypothesis.id).isZero(0.0)) continue;
    std::optional<UndetectableEffect> worst = WorstComponent(hypothesis, score, family);
    if (!worst) continue;
    const auto same = std::find_if(found.begin(), found.end(), [&](const auto& other) {
      return other.name == hypothesis.name;
    });
    if (same == found.end()) {
      found.push_back(std::move(*worst));
    } else if (worst->max_shift_sigmas > same->max_shift_sigmas) {
      *same = std::move(*worst);
    }
  }
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
    return a.max_shift_sigmas > b.max_shift_sigmas;
  });
  return found;
}

}  // namespace dn::diagnosis_internal
