#include <cmath>

#include "effects/physics.h"

namespace dn::effects {

void P2pRangeNoise(const EffectInput& input, ActiveEffects* active) {
  const double per_range = input.value[0];
  active->pair_sigma_m.emplace_back([per_range](double sigma_p_m, double mean_range_m) {
    return std::hypot(sigma_p_m, per_range * mean_range_m);
  });
}

}  // namespace dn::effects
