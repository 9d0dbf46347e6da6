#include "effects/physics.h"

namespace dn::effects {

void ImuVibration(const EffectInput& input, ActiveEffects* active) {
  active->imu_noise.emplace_back([times = input.entry.times, gyro_radps = input.value[0],
                                  accel_mps2 = input.value[1],
                                  random = input.MakeRandom()](ImuSample* sample) mutable {
    if (!times.During(sample->t_s)) return;
    sample->w_ib_b_radps += gyro_radps * random.Normal3();
    sample->f_b_mps2 += accel_mps2 * random.Normal3();
  });
}

}  // namespace dn::effects
