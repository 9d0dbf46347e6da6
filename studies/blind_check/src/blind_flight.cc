#include <dn/blind_check/blind_flight.h>
#include <dn/error.h>
#include <dn/geo/local_frame.h>
#include <fmt/format.h>

#include <algorithm>

#include "draw_effect.h"
#include "draw_lines.h"

namespace dn {
namespace {

constexpr double kBoresightSigma_rad = 0.3 * kRadPerDeg;
constexpr double kLongestWarmUp_s = 420.0;
constexpr double kShortestWarmUp_s = 240.0;

BlindContent DrawContent(Random& random) {
  const double share = random.Uniform();
  if (share < 0.2) return BlindContent::kNothing;
  if (share < 0.7) return BlindContent::kOneEffect;
  if (share < 0.8) return BlindContent::kTwoEffects;
  return BlindContent::kUnlistedEffect;
}

Scenario DrawScenario(const std::string& base, const std::vector<std::string>& changes,
                      Random& random) {
  Scenario scenario = ReadScenario(base, changes);
  ExpectOneScanner(scenario, "the blind check");
  if (scenario.plan.replay) {
    throw InvalidConfig(
        "scenario '" + base +
        "' replays a trajectory, so random lines are impossible; give one with plan.lines");
  }
  DrawLines(scenario.terrain.base_m, random, &scenario.plan);
  const double warm_up_s = random.Uniform(kShortestWarmUp_s, kLongestWarmUp_s);
  scenario.plan.warm_up_s = std::min(scenario.plan.warm_up_s, warm_up_s);
  const double fewer = random.Uniform(0.4, 0.8) * static_cast<double>(scenario.pairs.count);
  scenario.pairs.count = static_cast<long>(fewer);
  scenario.terrain.seed = 1 + DrawIndex(1000000, random);
  scenario.lidar.mounting.boresight_rad = kBoresightSigma_rad * random.Normal3();
  return scenario;
}

std::vector<Effect> DrawEffects(std::size_t count, double size_factor, const FlightTimes& times,
                                Random& random) {
  std::vector<const EffectSpec*> left = DiagnosableEffects();
  std::vector<Effect> drawn;
  while (drawn.size() < count) {
    const auto chosen = left.begin() + static_cast<std::ptrdiff_t>(DrawIndex(left.size(), random));
    drawn.push_back(DrawEffect(**chosen, size_factor, times, random));
    left.erase(chosen);
  }
  return drawn;
}

UnlistedEffect DrawOutsider(const BlindSuite& suite, const FlightTimes& times, Random& random) {
  if (!suite.physics.empty()) {
    return DrawDescribedPhysics(suite.physics[DrawIndex(suite.physics.size(), random)], times,
                                random);
  }
  const std::vector<std::string> names = UnlistedEffectNames();
  return DrawUnlistedEffect(names[DrawIndex(names.size(), random)], times, random);
}

}  // namespace

std::size_t EffectCount(BlindContent content) {
  switch (content) {
    case BlindContent::kNothing:
    case BlindContent::kUnlistedEffect:
      return 0;
    case BlindContent::kOneEffect:
    case BlindContent::kLeftOut:
      return 1;
    case BlindContent::kTwoEffects:
      return 2;
    case BlindContent::kThreeEffects:
      return 3;
  }
  return 0;
}

BlindContent BlindFlight::content() const {
  if (left_out) return BlindContent::kLeftOut;
  if (outsider) return BlindContent::kUnlistedEffect;
  constexpr BlindContent kByCount[] = {BlindContent::kNothing, BlindContent::kOneEffect,
                                       BlindContent::kTwoEffects, BlindContent::kThreeEffects};
  return kByCount[std::min<std::size_t>(scenario.effects.size(), 3)];
}

std::vector<std::string> BlindScenarioNames() {
  std::vector<std::string> names;
  for (const std::string& name : ScenarioNames()) {
    if (name.ends_with("_rest")) names.push_back(name);
  }
  return names;
}

std::uint64_t BlindFlightSeed(std::uint64_t suite_seed, int number) {
  return MixBits(suite_seed ^ MixBits(static_cast<std::uint64_t>(number)));
}

BlindFlight DrawBlindFlight(const BlindSuite& suite, int number) {
  Random random(suite.seed, fmt::format("blind flight {}", number));
  BlindFlight flight;
  flight.number = number;
  flight.seed = BlindFlightSeed(suite.seed, number);
  flight.base = suite.scenarios[DrawIndex(suite.scenarios.size(), random)];
  flight.scenario = DrawScenario(flight.base, suite.changes, random);
  flight.scenario.name = fmt::format("flight_{:03}", number);
  const FlightTimes times = PlannedTimes(flight.scenario, flight.seed);
  const BlindContent content = suite.only ? *suite.only : DrawContent(random);
  flight.left_out = content == BlindContent::kLeftOut;
  if (content == BlindContent::kUnlistedEffect) {
    flight.outsider = DrawOutsider(suite, times, random);
  } else {
    const std::size_t count = EffectCount(content);
    flight.scenario.effects = DrawEffects(count, suite.size_factor, times, random);
  }
  return flight;
}

}  // namespace dn
