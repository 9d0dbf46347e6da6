#include <dn/diagnosis/adapt.h>
#include <dn/diagnosis/diagnose.h>
#include <dn/diagnosis/gap_output.h>
#include <dn/diagnosis/replicate_scenario.h>
#include <dn/files/scanners.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <optional>
#include <sstream>

#include "command.h"
#include "noise_output.h"
#include "option_checks.h"

namespace dn::apps {
namespace {

struct GapArguments {
  CommonOptions common;
  std::string flight;
  bool quick = false;
  bool screen_only = false;
  bool limits = false;
  std::uint64_t seed = 1;
  double alpha = 0.05;
  double outside = GapOptions().outside;
  std::string effects;
  std::string without;
};

std::vector<std::string> SplitAtCommas(const std::string& text) {
  std::vector<std::string> words;
  std::istringstream in(text);
  for (std::string word; std::getline(in, word, ',');) words.push_back(word);
  return words;
}

GapOptions::Depth ChooseDepth(const GapArguments& options) {
  if (options.limits) return GapOptions::Depth::kLimits;
  if (options.screen_only) return GapOptions::Depth::kScreen;
  return options.quick ? GapOptions::Depth::kQuick : GapOptions::Depth::kFull;
}

GapOptions DiagnosisOptions(const GapArguments& options, Run* run) {
  GapOptions gap;
  gap.depth = ChooseDepth(options);
  gap.seed = options.seed;
  gap.alpha = options.alpha;
  gap.outside = options.outside;
  gap.threads = run->options().threads;
  gap.effects = SplitAtCommas(options.effects);
  gap.left_out = SplitAtCommas(options.without);
  gap.progress = [run](const std::string& stage, double fraction) {
    run->progress().Stage(stage, Share{fraction, 1.0, {}});
  };
  gap.interrupted = [] { return apps::SignalReceived(); };
  gap.Validate();
  return gap;
}

Flight Read(const GapArguments& options, Run* run) {
  run->progress().Stage("reading " + options.flight);
  const FlightConfig config = ReadFlightConfig(options.flight, options.common.changes);
  ExpectOneScanner(config, "dn gap");
  FlightNeeds needs;
  needs.imu = needs.gnss = config.imu.has_value() && config.gnss.has_value();
  needs.trajectory = !needs.imu || options.limits;
  needs.pairs = config.lidar.has_value();
  needs.optional = options.limits;
  return ReadFlight(config, needs);
}

void AddPlots(const GapDiagnosis& diagnosis, Run* run) {
  for (const GapPlot& plot : GapPlots(diagnosis)) {
    const auto svg = DrawSvg(plot.title, plot.x_label, plot.panels, SignalReceived);
    if (!svg) {
      run->progress().Warn(
          "no plots: gnuplot is not installed or failed; gap.json has the numbers");
      return;
    }
    run->AddFile(plot.file, *svg);
  }
}

std::string AdaptedFile(const GapResult& result) {
  const std::vector<std::string>& effects = result.diagnosis.verdict.effects;
  const std::string added =
      effects.empty() ? "nothing added" : fmt::format("{}", fmt::join(effects, ", "));
  return "# The flight with the effects that its diagnosis identified: " + added + ".\n" +
         FormatFlightFile(result.adapted);
}

void AddTwin(const Flight& flight, const GapResult& result, Run* run) {
  if (result.trajectory.empty() || !flight.imu) return;
  const Scenario twin = MakeReplicateScenario(
      flight, result.trajectory, VerdictCauses(result.diagnosis), result.boresight_rad);
  run->AddFile("twin.yaml", "# Scenario that simulates the flight again on its own trajectory.\n" +
                                FormatScenario(twin));
  run->AddFile(kReplayTrajectoryFile,
               FormatSbet(result.trajectory.points(), flight.pairs.has_value()));
}

void FillReport(const GapArguments& options, const Flight& flight, const GapDiagnosis& diagnosis,
                Run* run) {
  Json& report = run->report();
  report["flight"] = flight.config.name;
  report["seed"] = options.seed;
  report["counts"] = flight.counts;
  report["timings_s"]["read"] = flight.read_time_s;
  for (const auto& [stage, time_s] : diagnosis.timings_s) report["timings_s"][stage] = time_s;
}

void RunGap(const GapArguments& options, Run& run) {
  const GapOptions gap = DiagnosisOptions(options, &run);
  Flight flight = Read(options, &run);
  if (flight.imu && flight.gnss && !options.limits) {
    AdjustOptions adjust;
    adjust.with_pairs = flight.pairs.has_value();
    adjust.threads = run.options().threads;
    adjust.interrupted = gap.interrupted;
    const std::optional<NoiseSizes> noise = EstimateUnknownNoise(adjust, &flight, &run);
    if (noise) AddNoise(*noise, &run.report());
  }
  const GapResult result = Diagnose(flight, gap);
  const GapDiagnosis& diagnosis = result.diagnosis;
  run.progress().Stage("writing " + options.common.out.string());
  const std::string summary = GapSummary(diagnosis);
  run.AddFile("gap.json", FormatJson(GapJson(diagnosis)));
  run.AddFile("summary.txt", summary);
  run.AddFile("flight.adapted.yaml", AdaptedFile(result));
  run.AddFile("config.resolved.yaml", FormatFlightConfig(flight.config));
  AddTwin(flight, result, &run);
  AddPlots(diagnosis, &run);
  FillReport(options, flight, diagnosis, &run);
  fmt::print("{}", summary);
}

void AddDepth(CLI::App* app, GapArguments* options) {
  CLI::Option* quick = app->add_flag("--quick", options->quick,
                                     "Fewer Monte-Carlo replicates, for a shorter run time");
  CLI::Option* screen = app->add_flag("--screen-only", options->screen_only,
                                      "Screening only: no refits, no simulated replicates");
  CLI::Option* limits = app->add_flag(
      "--limits", options->limits,
      "Reports only which effects are detectable in such a flight; needs no measured values");
  quick->excludes(screen)->excludes(limits);
  screen->excludes(limits);
}

void AddGapOptions(CLI::App* app, GapArguments* options) {
  AddFlightOptions(app, &options->flight, &options->common);
  AddUnmodelled(app, &options->common);
  AddDepth(app, options);
  app->add_option("--seed", options->seed, "Seed of the Monte-Carlo replicates")
      ->check(WholeNumber(0))
      ->capture_default_str();
  app->add_option("--alpha", options->alpha,
                  "Significance level (false-alarm rate) of the gap test")
      ->check(PositiveNumber())
      ->capture_default_str();
  app->add_option("--outside", options->outside,
                  "Prior probability that what happened is not in the library, if something did: "
                  "at least 0, below 1")
      ->check(Probability())
      ->capture_default_str();
  app->add_option(
      "--effects", options->effects,
      "Comma-separated names of the only effects to consider (docs/reference/effects.md). "
      "Default: all");
  app->add_option("--without", options->without,
                  "Comma-separated names of effects that are not considered");
  AddCommonOptions(app, &options->common, true);
}

}  // namespace

void AddGap(CLI::App* program, Action* action) {
  auto options = std::make_shared<GapArguments>();
  CLI::App* app = program->add_subcommand(
      "gap",
      "Tests whether a flight fits its assumed model, finds the effects that cause a misfit, and "
      "reports how far adding them closes the gap");
  AddGapOptions(app, options.get());
  app->footer(
      "The exit code is 0 even if a gap is found. docs/guides/gap.md explains the results.\n"
      "Example: dn gap flight --out gap && dn calibrate gap/flight.adapted.yaml --out result");
  app->callback([options, action] {
    *action = [options] {
      options->common.inputs = FlightInputs(options->flight, options->common.changes);
      return Execute("gap", options->common, [&](Run& run) { RunGap(*options, run); });
    };
  });
}

}  // namespace dn::apps
