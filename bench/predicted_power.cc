/// predicted_power FLIGHTS SCENARIO...: whether effects are found as often as it was said before the
/// flight; the figures of docs/blind-check.md.
///
/// Of each scenario the size of every scalar effect is predicted that a test of .001 finds with a
/// given probability. Flights with other turbulence and noise are then flown with it, to either
/// side, and diagnosed; counted is how often the test finds it.
#include <dn/effects/effect_table.h>
#include <dn/gap/diagnose.h>
#include <dn/gap/limits.h>
#include <dn/sim/simulate.h>
#include <dn/study/design.h>
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <vector>

namespace dn::bench {
namespace {

constexpr double kAlpha = 1e-3;
constexpr double kQuantile = 3.2905;  // of the normal distribution, two sides of kAlpha
const std::vector<std::string> kEffects{
    "gnss_time_offset",   "gnss_time_drift",   "lidar_time_offset", "lidar_time_drift",
    "lidar_range_offset", "lidar_range_scale", "lidar_angle_scale", "lidar_scan_cone"};

/// A power, and the size that has it in units of the size with a power of .8.
struct Power {
  double predicted;
  double times;
};
constexpr Power kPowers[] = {{0.5, kQuantile / (kQuantile + 0.8416)}, {0.8, 1.0}};

struct Count {
  int flights = 0, found = 0;
  double share() const { return static_cast<double>(found) / flights; }
  double sigma(double predicted) const {
    return std::sqrt(predicted * (1.0 - predicted) / flights);
  }
};

std::vector<HiddenEffect> Predict(const Scenario& scenario) {
  const StudyDesign design = DesignOf(scenario);
  GapOptions options;
  options.effects = kEffects;
  return HiddenOnDesign(design.flight, design.states, options);
}

bool IsFound(const Scenario& scenario, std::uint64_t seed) {
  SimulateOptions simulate;
  simulate.seed = seed;
  const Flight flight = Simulate(scenario, simulate).flight;
  GapOptions options;
  options.depth = GapOptions::Depth::kScreen;
  options.effects = {scenario.effects.front().name};
  const GapDiagnosis diagnosis = Diagnose(flight, options).diagnosis;
  for (const GapCause& cause : diagnosis.causes) {
    if (cause.effect == options.effects.front()) return cause.p_value < kAlpha;
  }
  throw std::runtime_error("no test of " + options.effects.front() + ": " + diagnosis.verdict.text);
}

/// `first_seed`: of the flights, which no other count may share.
Count Fly(Scenario scenario, const HiddenEffect& effect, double times, int flights,
          std::uint64_t first_seed) {
  Count count;
  for (int i = 0; i < flights; ++i) {
    const double side = i % 2 == 0 ? 1.0 : -1.0;
    scenario.effects = {{effect.effect, {side * times * effect.minimal_detectable}, {}, {}}};
    count.found += IsFound(scenario, first_seed + static_cast<std::uint64_t>(i)) ? 1 : 0;
    ++count.flights;
  }
  return count;
}

void Print(const std::string& what, const Power& power, const Count& count) {
  fmt::print("{:<34} {:>9.2f} {:>6.3f} +- {:.3f} {:>8}\n", what, power.predicted, count.share(),
             count.sigma(power.predicted), count.flights);
  std::fflush(stdout);
}

void Run(int flights, const std::vector<std::string>& scenarios) {
  fmt::print("{:<34} {:>9} {:>15} {:>8}\n", "", "predicted", "seen", "flights");
  Count all[std::size(kPowers)];
  std::uint64_t seed = 1000;
  for (const std::string& name : scenarios) {
    const Scenario scenario = ReadScenario(name);
    for (const HiddenEffect& effect : Predict(scenario)) {
      if (!std::isfinite(effect.minimal_detectable)) continue;
      for (std::size_t k = 0; k < std::size(kPowers); ++k) {
        const Count count = Fly(scenario, effect, kPowers[k].times, flights, seed);
        seed += static_cast<std::uint64_t>(flights);
        Print(name + " " + effect.effect, kPowers[k], count);
        all[k].flights += count.flights;
        all[k].found += count.found;
      }
    }
  }
  for (std::size_t k = 0; k < std::size(kPowers); ++k) Print("all", kPowers[k], all[k]);
}

}  // namespace
}  // namespace dn::bench

int main(int argc, char** argv) {
  const int flights = argc > 2 ? std::atoi(argv[1]) : 0;
  if (flights < 1) {
    fmt::print(stderr, "usage: predicted_power FLIGHTS SCENARIO...\n");
    return 2;
  }
  try {
    dn::bench::Run(flights, {argv + 2, argv + argc});
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "predicted_power: {}\n", error.what());
    return 1;
  }
}
