#include <dn/files/effect_times.h>
#include <dn/geo/text_table.h>

namespace dn {

std::pair<double, double> ReadWindow(const YamlValue& value) {
  const Eigen::VectorXd window_s = ReadNumbers(value, 2);
  if (!(window_s[0] < window_s[1])) value.Fail("must be [begin, end] with begin before end");
  return {window_s[0], window_s[1]};
}

EffectTimes ReadEffectTimes(const YamlValue& entry, const EffectSpec& effect) {
  const std::string needed = TimingKey(effect.timing);
  for (const char* key : {"window_s", "t0_s"}) {
    if (entry[key] && key != needed) {
      entry[key].Fail("does not belong to '" + effect.name + "'");
    }
    if (!entry[key] && key == needed) {
      entry[key].Fail("is missing; '" + effect.name + "' needs it");
    }
  }
  EffectTimes times;
  if (effect.timing == EffectTiming::kWindow) times.window_s = ReadWindow(entry[needed]);
  if (effect.timing == EffectTiming::kStart) times.t0_s = entry[needed].Number();
  return times;
}

std::string FormatEffectTimes(const EffectTimes& times) {
  if (times.window_s) {
    return ", window_s: [" + FormatDouble(times.window_s->first) + ", " +
           FormatDouble(times.window_s->second) + "]";
  }
  return times.t0_s ? ", t0_s: " + FormatDouble(*times.t0_s) : "";
}

}  // namespace dn
