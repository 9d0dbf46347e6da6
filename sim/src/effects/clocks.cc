#include "effects/physics.h"

namespace dn::effects {
namespace {

/// Returns the shift of an entry: during its time span the tags are later by its value.
TagShift Later(const EffectInput& input) {
  const double offset_s = input.value[0];
  const EffectTimes times = input.entry.times;
  return {input.entry.name, input.entry.where,
          [offset_s, times](double t_s) { return times.During(t_s) ? offset_s : 0.0; }};
}

}  // namespace

void ImuClockStep(const EffectInput& input, ActiveEffects* active) {
  active->imu_tags.push_back(Later(input));
}

void GnssClockStep(const EffectInput& input, ActiveEffects* active) {
  active->gnss_tags.push_back(Later(input));
}

void GnssTimeOffset(const EffectInput& input, ActiveEffects* active) {
  active->gnss_tags.push_back(Later(input));
}

void GnssTimeDrift(const EffectInput& input, ActiveEffects* active) {
  active->gnss_tag_drift += input.value[0];
}

void LidarTimeOffset(const EffectInput& input, ActiveEffects* active) {
  const double offset_s = input.value[0];
  active->lidar_tag_shift_s.emplace_back([offset_s](double, const LidarSpan&) { return offset_s; });
}

void LidarTimeDrift(const EffectInput& input, ActiveEffects* active) {
  const double drift = input.value[0];
  active->lidar_tag_shift_s.emplace_back(
      [drift](double t_s, const LidarSpan& span) { return drift * (t_s - span.first_s); });
}

}  // namespace dn::effects
