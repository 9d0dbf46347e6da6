#include "draw_effect.h"

#include <dn/blind_check/blind_flight.h>

#include <algorithm>
#include <cmath>

namespace dn {
namespace {

constexpr double kShortestWindow_s = 10.0;
constexpr double kLongestStep_s = 200.0;

bool IsRatio(const EffectSpec& effect) { return effect.components.front().name == "ratio"; }

/// Returns true for a component that is a duration or a length instead of a size.
bool IsNotSize(const EffectSpec& effect, std::size_t i) {
  const std::string& name = effect.components[i].name;
  return name == "tau" || (name == "size" && i > 0);
}

double DrawRatio(double usual, double size_factor, Random& random) {
  return 1.0 + size_factor * (usual - 1.0) * LogUniform(0.5, 4.0, random);
}

/// Draws the components of a fixed effect with random signs and axes.
std::vector<double> DrawFixed(const EffectSpec& effect, double factor, Random& random) {
  std::vector<double> value = DrawAxes(effect.components.size(), factor, random);
  for (std::size_t i = 0; i < value.size(); ++i) value[i] *= effect.components[i].typical;
  return value;
}

std::vector<double> DrawStochastic(const EffectSpec& effect, double factor, Random& random) {
  std::vector<double> value;
  for (std::size_t i = 0; i < effect.components.size(); ++i) {
    const EffectComponent& part = effect.components[i];
    const double times = IsNotSize(effect, i) ? LogUniform(0.5, 2.0, random) : factor;
    value.push_back(std::min(times * part.typical, part.highest));
  }
  return value;
}

std::vector<double> DrawValue(const EffectSpec& effect, double size_factor, Random& random) {
  if (IsRatio(effect)) return {DrawRatio(effect.components.front().typical, size_factor, random)};
  const double factor = size_factor * LogUniform(1.0, 10.0, random);
  return effect.kind == EffectKind::kFixed ? DrawFixed(effect, factor, random)
                                           : DrawStochastic(effect, factor, random);
}

/// Draws a window of random length inside [begin_s, end_s].
std::pair<double, double> WindowInside(double begin_s, double end_s, double longest_s,
                                       Random& random) {
  const double most_s = std::min(longest_s, end_s - begin_s);
  const double length_s = random.Uniform(std::min(kShortestWindow_s, most_s), most_s);
  const double start_s = begin_s + random.Uniform() * (end_s - begin_s - length_s);
  return {start_s, start_s + length_s};
}

/// Draws a window inside one strip for the inertial unit. For GNSS, which has few epochs, the
/// window lies anywhere between the first and the last strip.
std::pair<double, double> DrawWindow(const EffectSpec& effect, const FlightTimes& times,
                                     Random& random) {
  if (effect.sensor == EffectSensor::kGnss) {
    return WindowInside(times.strips.front().t0_s, times.strips.back().t1_s, kLongestStep_s,
                        random);
  }
  const StripInterval& strip = times.strips[DrawIndex(times.strips.size(), random)];
  return WindowInside(strip.t0_s, strip.t1_s, strip.t1_s - strip.t0_s, random);
}

/// Draws a start time well between the first and the last strip, so that pairs lie on both sides.
double DrawStart(const FlightTimes& times, Random& random) {
  const double first_s = times.strips.front().t0_s, last_s = times.strips.back().t1_s;
  return first_s + random.Uniform(0.15, 0.85) * (last_s - first_s);
}

}  // namespace

double DrawnSize(const Effect& effect) {
  const EffectSpec& spec = *FindEffect(effect.name);
  double size = 0.0;
  for (std::size_t i = 0; i < effect.value.size(); ++i) {
    const double usual = spec.components[i].typical;
    if (IsRatio(spec)) return (effect.value[i] - 1.0) / (usual - 1.0);
    if (!IsNotSize(spec, i)) size = std::max(size, std::abs(effect.value[i]) / usual);
  }
  return size;
}

std::vector<const EffectSpec*> DiagnosableEffects() {
  std::vector<const EffectSpec*> effects;
  for (const EffectSpec& effect : EffectTable()) {
    if (effect.kind != EffectKind::kFault) effects.push_back(&effect);
  }
  return effects;
}

Effect DrawEffect(const EffectSpec& effect, double size_factor, const FlightTimes& times,
                  Random& random) {
  Effect drawn;
  drawn.name = effect.name;
  drawn.value = DrawValue(effect, size_factor, random);
  if (effect.timing == EffectTiming::kWindow) {
    drawn.times.window_s = DrawWindow(effect, times, random);
  }
  if (effect.timing == EffectTiming::kStart) drawn.times.t0_s = DrawStart(times, random);
  return drawn;
}

}  // namespace dn
