#include <dn/diagnosis/effect_posterior.h>

#include "competing_effects.h"
#include "gnss_process.h"
#include "network_hypotheses.h"
#include "unmodelled.h"

namespace dn {
namespace diagnosis_internal {
namespace {

/// Appends the components of an effect that have a prior.
void AppendPriors(EffectId effect, const Eigen::VectorXd& sigma, EffectPosterior* posterior) {
  for (Eigen::Index k = 0; k < sigma.size(); ++k) {
    if (sigma[k] == 0.0) continue;
    posterior->effect.push_back(effect);
    posterior->component.push_back(k);
    Eigen::VectorXd& all = posterior->prior_sigma;
    all.conservativeResize(all.size() + 1);
    all[all.size() - 1] = sigma[k];
  }
}

}  // namespace
}  // namespace diagnosis_internal

EffectPosterior ComputeEffectPosterior(const Solution& solution) {
  namespace internal = diagnosis_internal;
  const FlightNetwork& network = solution.network();
  const UnmodelledPrior prior = MakeUnmodelledPrior(network.flight().config);
  internal::Library library =
      internal::MakeNetworkHypotheses(network, solution.marginals().threads(), {});
  const auto process = internal::AddGnssProcess(network, solution.linearized(), &library);
  std::vector<BlockId> unknowns{network.calibration().boresight().id};
  for (const BlockId unknown : internal::EffectUnknowns(network)) unknowns.push_back(unknown);
  const JointScore score = ScoreEffects(solution.marginals(), library.blocks, unknowns);
  const internal::UnmodelledUnknowns effects(library, prior, score, process);
  EffectPosterior posterior;
  if (effects.empty()) return posterior;
  for (const internal::Hypothesis& hypothesis : library.hypotheses) {
    if (!hypothesis.id || !EffectRow(*hypothesis.id).fixed()) continue;
    if (hypothesis.Components(score).empty()) continue;
    internal::AppendPriors(*hypothesis.id, prior.Sigma(*hypothesis.id), &posterior);
  }
  const Eigen::Index n = posterior.prior_sigma.size();
  const Eigen::MatrixXd root = effects.PosteriorRoot();
  const Eigen::MatrixXd shift = score.shift(Eigen::all, effects.components()) * root;
  posterior.estimate = effects.estimate()(effects.components()).head(n);
  posterior.covariance = root.topRows(n) * root.topRows(n).transpose();
  posterior.added = shift * shift.transpose();
  posterior.cross = -shift * root.topRows(n).transpose();
  return posterior;
}

}  // namespace dn
