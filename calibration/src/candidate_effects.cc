#include "candidate_effects.h"

#include <algorithm>

namespace dn {

std::vector<CandidateEffect> CandidateEffects(const FlightNetwork& network) {
  std::vector<CandidateEffect> effects;
  internal::AddLidarCandidates(network, &effects);
  internal::AddGnssCandidates(network, &effects);
  internal::AddInertialCandidates(network, &effects);
  std::erase_if(effects, [](const CandidateEffect& effect) { return effect.model.empty(); });
  return effects;
}

namespace internal {

EffectModel ModelOfBlock(const Network& net, const std::vector<FactorId>& factors, BlockId block) {
  EffectModel model;
  if (!net.block(block).held) return model;
  for (const FactorId id : factors) {
    Eigen::VectorXd r;
    std::vector<Eigen::MatrixXd> J;
    if (!net.factor(id).active || !net.EvaluateFactor(id, &r, &J)) continue;
    const std::vector<BlockId>& blocks = net.factor(id).blocks;
    const auto at = std::find(blocks.begin(), blocks.end(), block);
    if (at == blocks.end()) continue;
    model.push_back({id, J[static_cast<std::size_t>(at - blocks.begin())]});
  }
  return model;
}

std::vector<const double*> ValuesOf(const Network& net, FactorId factor) {
  std::vector<const double*> x;
  for (const BlockId id : net.factor(factor).blocks) x.push_back(net.block(id).value.get());
  return x;
}

}  // namespace internal
}  // namespace dn
