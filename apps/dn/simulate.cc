#include <dn/adjustment/adjust.h>
#include <dn/files/scanners.h>
#include <dn/sim/draw_effects.h>
#include <dn/sim/scenario.h>
#include <dn/sim/simulate.h>
#include <fmt/format.h>

#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "command.h"
#include "option_checks.h"

namespace dn::apps {
namespace {

struct SimulateArguments {
  CommonOptions common;
  std::string scenario;
  std::uint64_t seed = 1;
  bool noise_free = false;
  std::optional<double> unmodelled;  ///< factor of the priors
};

/// Writes the point clouds and returns the counts of pulses and points per scanner and strip.
Json WriteStrips(const SimulatedFlight& simulated, Run& run) {
  const std::vector<CloudCounts> counts =
      WriteClouds(simulated, run.options().threads, run.files(),
                  [&](const StripInterval& strip, double fraction) {
                    if (SignalReceived()) throw dn::Interrupted();
                    run.progress().Stage("strip " + strip.name, Share{fraction, 1.0, {}});
                  });
  Json clouds = Json::array();
  for (std::size_t i = 0; i < counts.size(); ++i) {
    clouds.push_back({{"name", simulated.strips[i % simulated.strips.size()].name},
                      {"pulses", counts[i].pulses},
                      {"points", counts[i].points},
                      {"lost on water", counts[i].on_water}});
    const std::string scanner =
        ScannerAt(simulated.flight.config, i / simulated.strips.size()).name;
    if (!scanner.empty()) clouds.back()["scanner"] = scanner;
  }
  return clouds;
}

/// Returns the numbers of points of a strip: ", 12 points", ", 12 points of nadir, 13 of oblique".
std::string PointWords(const Json& clouds, const std::string& strip) {
  std::string text;
  for (const Json& cloud : clouds) {
    if (cloud["name"] != strip) continue;
    text +=
        fmt::format(", {}{}", cloud["points"].get<std::uint64_t>(), text.empty() ? " points" : "");
    if (cloud.contains("scanner")) text += " of " + cloud["scanner"].get<std::string>();
  }
  return text;
}

Scenario SimulatedScenario(const SimulateArguments& options) {
  Scenario scenario = ReadScenario(options.scenario, options.common.changes);
  if (!options.unmodelled) return scenario;
  return WithDrawnEffects(std::move(scenario), *options.unmodelled, options.seed);
}

void RunSimulate(const SimulateArguments& options, Run& run) {
  const Scenario scenario = SimulatedScenario(options);
  SimulateOptions simulate;
  simulate.seed = options.seed;
  simulate.noise = !options.noise_free;
  simulate.progress = [&](const std::string& stage, double fraction) {
    if (SignalReceived()) throw dn::Interrupted();
    run.progress().Stage(stage, Share{fraction, 1.0, {}});
  };
  const SimulatedFlight simulated = Simulate(scenario, simulate);
  run.progress().Stage("writing " + options.common.out.string());
  const Flight& flight = simulated.flight;
  WriteFlight(simulated, run.files());
  const Json clouds = WriteStrips(simulated, run);
  run.AddFile("config.resolved.yaml", FormatFlightConfig(flight.config));
  const std::size_t pairs = flight.pairs ? flight.pairs->pairs.size() : 0;
  run.report()["scenario"] = scenario.name;
  run.report()["seed"] = options.seed;
  run.report()["noise"] = !options.noise_free;
  run.report()["counts"] = {{"imu epochs", flight.imu->samples.size()},
                            {"gnss epochs", flight.gnss->epochs.size()},
                            {"pairs", pairs},
                            {"strips", simulated.strips.size()}};
  run.report()["point_clouds"] = clouds;
  fmt::print("flight {}: {} inertial epochs, {} GNSS epochs, {} strips, {} pairs, seed {}\n",
             scenario.name, flight.imu->samples.size(), flight.gnss->epochs.size(),
             simulated.strips.size(), pairs, options.seed);
  for (const StripInterval& strip : simulated.strips) {
    fmt::print("  strip {}: {:.1f} .. {:.1f} s{}\n", strip.name, strip.t0_s, strip.t1_s,
               PointWords(clouds, strip.name));
  }
}

/// Lists the shipped scenarios whose names have this ending, as lines of the help text. An empty
/// `ending` lists those with neither _rest nor _effects.
std::string ShippedLines(std::string_view ending) {
  constexpr std::size_t kWidth = 80;
  std::string text, line;
  for (const std::string& name : ScenarioNames()) {
    const bool as_it_flies = !name.ends_with("_rest") && !name.ends_with("_effects");
    if (ending.empty() ? !as_it_flies : !name.ends_with(ending)) continue;
    if (line.size() + name.size() > kWidth) text += std::exchange(line, "") + "\n";
    line += "  " + name;
  }
  return text + line + "\n";
}

std::string Footer() {
  return "Shipped scenarios with in-flight noise (docs/guides/flight-noise.md):\n" +
         ShippedLines("") + "with the noise of a sensor at rest, from its data sheet:\n" +
         ShippedLines("_rest") +
         "with noise at rest, and the causes of in-flight noise as unmodelled effects:\n" +
         ShippedLines("_effects") + "Example: dn simulate lar3 --out flight --seed 7";
}

}  // namespace

void AddSimulate(CLI::App* program, Action* action) {
  auto options = std::make_shared<SimulateArguments>();
  CLI::App* app = program->add_subcommand("simulate", "Simulates a flight folder from a scenario");
  app->add_option("SCENARIO", options->scenario,
                  "Scenario file or name of a shipped scenario (list below)")
      ->required();
  app->add_option("--seed", options->seed, "Seed of all random numbers")
      ->check(WholeNumber(0))
      ->capture_default_str();
  app->add_flag("--noise-free", options->noise_free,
                "Adds no noise; flight.yaml still has the stochastic model of the scenario");
  app->add_option("--draw-unmodelled", options->unmodelled,
                  "Adds every effect that the assumed model leaves out, drawn from its prior times "
                  "this factor; truth.yaml lists them")
      ->check(PositiveNumber());
  AddChanges(app, "the scenario", "strips=true", &options->common);
  AddCommonOptions(app, &options->common, true);
  app->footer(Footer());
  app->callback([options, action] {
    *action = [options] {
      options->common.inputs = ScenarioInputs(options->scenario, options->common.changes);
      options->common.writes_flight = true;
      return Execute("simulate", options->common, [&](Run& run) { RunSimulate(*options, run); });
    };
  });
}

}  // namespace dn::apps
