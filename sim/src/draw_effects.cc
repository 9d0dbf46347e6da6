#include <dn/effects/effect_table.h>
#include <dn/effects/gnss_process_prior.h>
#include <dn/files/unmodelled.h>
#include <dn/sim/draw_effects.h>
#include <dn/sim/random.h>

#include <cmath>
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

Effect DrawGnssProcess(const Eigen::Vector3d& stated_enu_m, double factor, std::uint64_t seed) {
  using Prior = GnssProcessPrior;
  Random random(seed, "unmodelled GNSS process");
  const double size = Prior::kMedianSize * std::exp(Prior::kLogSizeSigma * random.Normal());
  const Eigen::Vector3d sigma_m = factor * size * Prior::StatedSigma(stated_enu_m) * Prior::Axes();
  const double tau_s =
      Prior::kShortestTauS * std::pow(Prior::kLongestTauS / Prior::kShortestTauS, random.Uniform());
  return {EffectName(EffectId::kGnssCorrelatedNoise),
          {sigma_m.x(), sigma_m.y(), sigma_m.z(), tau_s},
          {},
          {}};
}

void DrawSharedPairErrors(double factor, std::uint64_t seed, PairScenario* pairs) {
  constexpr double kSmallest = -7.0, kShortestM = 15.0;  // exponent of 2
  Random random(seed, "unmodelled shared errors of pairs");
  if (random.Uniform() < 0.5) return;
  const double exponent = kSmallest + std::floor(random.Uniform(0.0, 1.0 - kSmallest));
  const double ratio = factor * factor * std::exp2(exponent);
  pairs->shared_fraction = ratio / (1.0 + ratio);
  pairs->shared_length_m = kShortestM * std::exp2(std::floor(random.Uniform(0.0, 4.0)));
}

Scenario WithDrawnEffects(Scenario scenario, double factor, std::uint64_t seed) {
  FlightConfig config;
  config.imu.emplace().model = scenario.imu.model;
  for (Effect& effect : DrawEffects(MakeUnmodelledPrior(config), factor, seed)) {
    scenario.effects.push_back(std::move(effect));
  }
  if (scenario.gnss.processes.empty()) {
    scenario.effects.push_back(DrawGnssProcess(scenario.gnss.sigma_enu_m, factor, seed));
  }
  if (scenario.pairs.shared_fraction == 0.0) DrawSharedPairErrors(factor, seed, &scenario.pairs);
  return scenario;
}

}  // namespace dn
