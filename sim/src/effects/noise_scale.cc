#include "effects/physics.h"

namespace dn::effects {

void GyroNoiseScale(const EffectInput& input, ActiveEffects* active) {
  active->gyro_noise_ratio *= input.value[0];
}

void AccelNoiseScale(const EffectInput& input, ActiveEffects* active) {
  active->accel_noise_ratio *= input.value[0];
}

void GnssNoiseScale(const EffectInput& input, ActiveEffects* active) {
  active->gnss_noise_ratio *= input.value[0];
}

void P2pNoiseScale(const EffectInput& input, ActiveEffects* active) {
  const double ratio = input.value[0];
  active->pair_sigma_m.emplace_back(
      [ratio](double sigma_p_m, double) { return ratio * sigma_p_m; });
}

}  // namespace dn::effects
