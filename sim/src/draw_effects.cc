#include <dn/effects/effect_table.h>
#include <dn/sim/draw_effects.h>
#include <dn/sim/random.h>

#include <cstddef>
#include <utility>

namespace dn {

std::vector<Effect> DrawEffects(const UnmodelledPrior& prior, double factor, std::uint64_t seed) {
  Random random(seed, "unmodelled effects");
  std::vector<Effect> effects;
  for (const EffectSpec& effect : EffectTable()) {
    if (!effect.fixed()) continue;
    const Eigen::VectorXd sigma_si = prior.Sigma(effect.id);
    if (sigma_si.isZero(0.0)) continue;
    Effect drawn{effect.name, {}, {}, {}};
    for (std::size_t k = 0; k < effect.components.size(); ++k) {
      drawn.value.push_back(factor * random.Normal() * sigma_si[static_cast<Eigen::Index>(k)] /
                            effect.components[k].to_si);
    }
    effects.push_back(std::move(drawn));
  }
  return effects;
}

}  // namespace dn
