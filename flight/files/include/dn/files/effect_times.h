#pragma once

#include <dn/config/yaml_value.h>
#include <dn/effects/effect_table.h>

#include <optional>
#include <string>
#include <utility>

namespace dn {

/// When an effect is there, in GPS seconds of week: as its timing says, a window, a start, or
/// neither for the whole flight.
struct EffectTimes {
  std::optional<std::pair<double, double>> window_s{};  ///< first and last
  std::optional<double> t0_s{};

  bool During(double t_s) const {
    if (window_s) return t_s >= window_s->first && t_s <= window_s->second;
    return !t0_s || t_s >= *t0_s;
  }
};

/// A window in time, [begin, end]. Throws InvalidConfig unless it begins before it ends.
std::pair<double, double> ReadWindow(const YamlValue& value);

/// The keys `window_s` and `t0_s` beside an effect. Throws InvalidConfig where the effect needs one
/// that is missing, has one that does not belong to it, or a window ends before it begins.
EffectTimes ReadEffectTimes(const YamlValue& entry, const EffectSpec& effect);

/// ", window_s: [begin, end]" or ", t0_s: start", as ReadEffectTimes reads them; empty for neither.
std::string FormatEffectTimes(const EffectTimes& times);

}  // namespace dn
