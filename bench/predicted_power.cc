/// predicted_power FLIGHTS SCENARIO...: checks whether effects are found as often as predicted
/// before the flight; its figures are in docs/validation/blind-check.md.
///
/// For each scenario, eight plans with different turbulence predict how often a test at level .001
/// finds a scalar effect of a given size. Flights with their own turbulence and noise are then
/// simulated with the effect, in both signs, and diagnosed. The program counts how often the test
/// finds the effect.
#include <dn/diagnosis/diagnose.h>
#include <dn/diagnosis/limits.h>
#include <dn/sim/simulate.h>
#include <dn/study/design.h>
#include <dn/study/study.h>
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <map>
#include <numbers>
#include <string>
#include <vector>

namespace dn::bench {
namespace {

constexpr double kAlpha = 1e-3;
constexpr double kQuantile = 3.2905;  // two-sided quantile of the normal distribution at kAlpha
constexpr double kNonCentrality = 4.1321;  // non-centrality for a power of .8
constexpr std::uint64_t kPlans = 8;
const std::vector<std::string> kEffects{
    "gnss_time_offset",   "gnss_time_drift",   "lidar_time_offset", "lidar_time_drift",
    "lidar_range_offset", "lidar_range_scale", "lidar_angle_scale", "lidar_scan_cone"};

// Tested sizes, relative to the size that the first plan finds with a power of .8. The first is the
// size for a power of .5, the second that size itself.
constexpr double kTimes[] = {kQuantile / kNonCentrality, 1.0};

struct Count {
  double predicted = 0.0;  ///< sum of the predicted powers over the flights
  int flights = 0, found = 0;
};

/// Returns the minimal detectable bias of each effect in a flight whose turbulence has this seed.
std::map<std::string, double> Plan(const Scenario& scenario, std::uint64_t seed) {
  DesignOptions planning;
  planning.seed = seed;
  const StudyDesign design = MakeDesign(scenario, planning);
  GapOptions options;
  options.effects = kEffects;
  std::map<std::string, double> sizes;
  for (const DetectionLimit& effect : DesignDetectionLimits(SolveAtStates(design), options)) {
    if (std::isfinite(effect.minimal_detectable)) sizes[effect.effect] = effect.minimal_detectable;
  }
  return sizes;
}

/// Returns the power for an effect of this size, averaged over the plans, because the turbulence of
/// the flight is unknown in advance.
double ComputePower(const std::string& effect, double size,
                    const std::vector<std::map<std::string, double>>& plans) {
  double power = 0.0;
  for (const auto& plan : plans) {
    const double off = size / plan.at(effect) * kNonCentrality - kQuantile;
    power += 0.5 * std::erfc(-off / std::numbers::sqrt2) / static_cast<double>(plans.size());
  }
  return power;
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

/// Counts the flights in which the effect is found. `first_seed` starts the seeds of the flights,
/// which no other count may use.
int Found(Scenario scenario, const std::string& effect, double size, int flights,
          std::uint64_t first_seed) {
  int found = 0;
  for (int i = 0; i < flights; ++i) {
    scenario.effects = {{effect, {i % 2 == 0 ? size : -size}, {}, {}}};
    found += IsFound(scenario, first_seed + static_cast<std::uint64_t>(i)) ? 1 : 0;
  }
  return found;
}

void Print(const std::string& what, const Count& count) {
  const double p = count.predicted / count.flights;
  fmt::print("{:<34} {:>9.3f} {:>6.3f} +- {:.3f} {:>8}\n", what, p,
             static_cast<double>(count.found) / count.flights,
             std::sqrt(p * (1.0 - p) / count.flights), count.flights);
  std::fflush(stdout);
}

void Run(int flights, const std::vector<std::string>& scenarios) {
  fmt::print("{:<34} {:>9} {:>15} {:>8}\n", "", "predicted", "seen", "flights");
  Count all[std::size(kTimes)];
  std::uint64_t seed = 1000;
  for (const std::string& name : scenarios) {
    const Scenario scenario = ReadScenario(name);
    std::vector<std::map<std::string, double>> plans;
    for (std::uint64_t plan = 1; plan <= kPlans; ++plan) plans.push_back(Plan(scenario, plan));
    for (const auto& [effect, detectable] : plans.front()) {
      for (std::size_t k = 0; k < std::size(kTimes); ++k) {
        const double size = kTimes[k] * detectable;
        const Count count{flights * ComputePower(effect, size, plans), flights,
                          Found(scenario, effect, size, flights, seed)};
        Print(fmt::format("{} {}", name, effect), count);
        all[k].predicted += count.predicted;
        all[k].flights += count.flights;
        all[k].found += count.found;
        seed += static_cast<std::uint64_t>(flights);
      }
    }
  }
  for (const Count& count : all) Print("all", count);
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
