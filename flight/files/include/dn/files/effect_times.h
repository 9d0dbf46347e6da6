#pragma once

#include <dn/config/yaml_value.h>
#include <dn/effects/effect_table.h>

#include <optional>
#include <string>
#include <utility>

namespace dn {

/// The time during which an effect acts, GPS seconds of week: a window, a start, or neither for the
/// whole flight.
struct EffectTimes {
  std::optional<std::pair<double, double>> window_s{};  ///< first and last time of the window
  std::optional<double> t0_s{};

  bool During(double t_s) const {
    if (window_s) return t_s >= window_s->first && t_s <= window_s->second;
    return !t0_s || t_s >= *t0_s;
  }
};

/// Reads a time window [begin, end]. Throws InvalidConfig unless it begins before it ends.
std::pair<double, double> ReadWindow(const YamlValue& value);

/// Reads the keys `window_s` and `t0_s` of an effect. Throws InvalidConfig if a required key is
/// missing, if a key does not belong to the effect, or if a window ends before it begins.
EffectTimes ReadEffectTimes(const YamlValue& entry, const EffectSpec& effect);

/// Returns ", window_s: [begin, end]" or ", t0_s: start" in the form that ReadEffectTimes reads;
/// empty without times.
std::string FormatEffectTimes(const EffectTimes& times);

}  // namespace dn
