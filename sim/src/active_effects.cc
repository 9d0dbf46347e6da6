#include "active_effects.h"

#include <dn/effects/effect_table.h>
#include <dn/error.h>

#include <cmath>

#include "effects/registry.h"

namespace dn {

Eigen::Vector3d TurnedTowardAxis(const Eigen::Vector3d& axis, double angle_rad,
                                 const Eigen::Vector3d& u) {
  const double along = axis.dot(u);
  const Eigen::Vector3d across = u - along * axis;
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  const double length = across.norm();
  return (along * c + length * s) * axis + (c - along / length * s) * across;
}

ActiveEffects MakeActiveEffects(const Scenario& scenario, std::uint64_t seed, bool noise) {
  ActiveEffects active;
  for (const SimulatedEffect& simulated : SimulatedEffects()) {
    const EffectSpec* spec = FindEffect(simulated.name);
    int index = 0;
    for (const Effect& effect : scenario.effects) {
      if (effect.name != simulated.name) continue;
      const std::string stream = effect.name + " " + std::to_string(index++);
      if (!noise && spec->kind == EffectKind::kStochastic) continue;
      simulated.activate({scenario, effect, ValueInSi(*spec, effect.value), seed, stream}, &active);
    }
  }
  return active;
}

void RefuseStepBack(const std::vector<TagShift>& shifts, double before_s, double t_s) {
  for (const TagShift& shift : shifts) {
    if (shift.shift_s(t_s) < shift.shift_s(before_s)) {
      throw InvalidConfig(shift.effect + ": the tags would step back", shift.where);
    }
  }
  throw InvalidInput("the tags would step back");
}

double Tag(const std::vector<TagShift>& shifts, double t_s) {
  double tag_s = t_s;
  for (const TagShift& shift : shifts) tag_s += shift.shift_s(t_s);
  return tag_s;
}

bool InGap(const std::vector<DataGap>& gaps, double t_s) {
  for (const DataGap& gap : gaps) {
    if (gap.times.During(t_s)) return true;
  }
  return false;
}

}  // namespace dn
