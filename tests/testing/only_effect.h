#pragma once

#include <dn/effects/effect_table.h>
#include <dn/files/unmodelled.h>

namespace dn::testing {

/// Returns the section `unmodelled` in which one effect alone has a prior: the same sigma for each
/// component, in the unit of the effect.
inline UnmodelledConfig OnlyEffect(EffectId only, double sigma) {
  UnmodelledConfig config;
  for (const EffectSpec& effect : EffectTable()) {
    if (effect.fixed()) config.sizes.push_back({effect.id, {effect.id == only ? sigma : 0.0}});
  }
  return config;
}

}  // namespace dn::testing
