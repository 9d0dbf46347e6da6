#include "effects/physics.h"

namespace dn::effects {

void ImuGap(const EffectInput& input, ActiveEffects* active) {
  active->imu_gaps.push_back({input.entry.name, input.entry.where, input.entry.times});
}

void GnssOutage(const EffectInput& input, ActiveEffects* active) {
  active->gnss_gaps.push_back({input.entry.name, input.entry.where, input.entry.times});
}

}  // namespace dn::effects
