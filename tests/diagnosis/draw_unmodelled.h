#pragma once

#include <dn/effects/effect_table.h>
#include <dn/effects/unmodelled_prior.h>
#include <fmt/format.h>

#include <random>
#include <string>
#include <vector>

namespace dn::diagnosis_test {

/// Returns `effects:` of a scenario with every effect of a prior, each component drawn from it.
inline std::string DrawUnmodelled(const UnmodelledPrior& prior, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::string text;
  for (const EffectSpec& effect : EffectTable()) {
    if (!effect.fixed()) continue;
    const Eigen::VectorXd sigma_si = prior.Sigma(effect.id);
    if (sigma_si.isZero(0.0)) continue;
    std::vector<double> value;
    for (std::size_t k = 0; k < effect.components.size(); ++k) {
      const double sigma = sigma_si[static_cast<Eigen::Index>(k)] / effect.components[k].to_si;
      value.push_back(sigma * normal(random));
    }
    text += fmt::format("{}{{effect: {}, value: [{}]}}", text.empty() ? "" : ", ", effect.name,
                        fmt::join(value, ", "));
  }
  return "effects: [" + text + "]\n";
}

}  // namespace dn::diagnosis_test
