#include <dn/axis_names.h>
#include <dn/montecarlo/summary.h>
#include <dn/report/plot.h>
#include <dn/sim/scenario.h>
#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "command.h"
#include "fleet.h"
#include "option_checks.h"
#include "series_records.h"
#include "sha256.h"

namespace dn::apps {
namespace {

struct MonteCarloArguments {
  CommonOptions common;
  std::string scenario;
  int flights = 100;
  std::uint64_t first_seed = 1;
  bool without_pairs = false;
  double epoch_spacing_s = 1.0;
  std::optional<double> unmodelled;
  std::string shard = "1/1";
};

PlotSeries Level(const std::string& label, double value, const std::vector<double>& t_s) {
  return {label, {{t_s.front(), value}, {t_s.back(), value}}};
}

void AddPlots(const MonteCarloSummary& summary, const std::vector<FlightRecord>& records,
              const std::string& scenario, Run* run) {
  std::vector<PlotPanel> panels;
  for (const TrajectoryConsistency& c : summary.trajectory) {
    if (c.t_s.empty()) continue;
    PlotSeries nees{"NEES / 3", {}};
    for (std::size_t k = 0; k < c.t_s.size(); ++k) {
      nees.points.emplace_back(c.t_s[k], c.nees_per_dof[k]);
    }
    panels.push_back(
        {c.quantity,
         {nees, Level("99 % low", c.band.low, c.t_s), Level("99 % high", c.band.high, c.t_s)}});
  }
  const std::string title =
      fmt::format("{}: trajectory NEES over {} flights", scenario, summary.flights);
  const auto trajectory = DrawSvg(title, "time since the first node [s]", panels, SignalReceived);
  if (!trajectory) {
    run->progress().Warn("no plots: gnuplot is not installed or failed");
    return;
  }
  run->AddFile("trajectory_nees.svg", *trajectory);
  if (!summary.with_pairs) return;
  std::vector<PlotPanel> angles;
  for (int i = 0; i < 3; ++i) {
    PlotSeries errors{"error / sigma", {}, PlotStyle::kPoints};
    std::vector<double> seeds;
    for (const FlightRecord& record : records) {
      if (!record.failure.empty()) continue;
      const double sigma = std::sqrt(record.boresight_covariance_rad2(i, i));
      seeds.push_back(static_cast<double>(record.seed));
      errors.points.emplace_back(seeds.back(), record.boresight_error_rad[i] / sigma);
    }
    angles.push_back(
        {kRollPitchYaw[i], {errors, Level("+3", 3.0, seeds), Level("-3", -3.0, seeds)}});
  }
  if (const auto svg =
          DrawSvg(scenario + ": boresight errors in sigmas", "seed", angles, SignalReceived)) {
    run->AddFile("boresight_errors.svg", *svg);
  }
}

std::vector<FlightRecord> Fly(const MonteCarloArguments& options, const Scenario& scenario,
                              const RecordFolder& folder, const RecordReader<FlightRecord>& reader,
                              const std::vector<std::uint64_t>& seeds, Run* run) {
  FlightRecordOptions how;
  how.with_pairs = !options.without_pairs;
  how.epoch_spacing_s = options.epoch_spacing_s;
  how.unmodelled = options.unmodelled;
  how.interrupted = [] { return SignalReceived(); };
  std::vector<FlightRecord> records(seeds.size());
  const auto fly = [&](std::size_t k) {
    std::optional<FlightRecord> record = folder.Read(seeds[k], reader);
    if (!record) {
      record = RunFlight(scenario, seeds[k], how);
      folder.Write(seeds[k], ToJson(*record));
    }
    records[k] = std::move(*record);
  };
  const auto on_finished = [&](std::size_t k) {
    if (records[k].failure.empty()) return;
    run->progress().Warn(fmt::format("seed {}: {}", seeds[k], records[k].failure));
  };
  SimulateAll(seeds.size(), run, fly, on_finished);
  return records;
}

void MonteCarlo(const MonteCarloArguments& options, Run& run) {
  const std::vector<std::string>& changes = options.common.changes;
  const Scenario scenario = ReadScenario(options.scenario, changes);
  ExpectOneScanner(scenario, "dn monte-carlo");
  const std::string text =
      changes.empty() ? ScenarioText(options.scenario) : FormatScenario(scenario);
  const Json made_from = {{"scenario", text},
                          {"with_pairs", !options.without_pairs},
                          {"epoch_spacing_s", options.epoch_spacing_s},
                          {"unmodelled", options.unmodelled.value_or(0.0)},
                          {"version", DN_VERSION},
                          {"program", ProgramHash()}};
  const Series series{"monte-carlo", options.first_seed,
                      static_cast<std::uint64_t>(options.flights), ParseShard(options.shard),
                      RecordFolder::MadeFromHash(made_from)};
  const RecordFolder folder(options.common.out / RecordFolderName(series.command), made_from);
  const std::vector<FlightRecord> records =
      Fly(options, scenario, folder, FlightRecordReader(made_from), series.Numbers(), &run);
  run.report()["seed"] = options.first_seed;
  run.report()["series"] = SeriesToJson(series);
  AddMonteCarloResults(made_from, records, &run);
}

}  // namespace

void AddMonteCarloResults(const Json& made_from, const std::vector<FlightRecord>& records,
                          Run* run) {
  const std::string text = made_from.at("scenario");
  const std::string name = ParseScenario(text, "scenario").name;
  const MonteCarloSummary summary = Summarise(records);
  run->report()["scenario"] = name;
  run->report()["counts"] = {{"flights", summary.flights}, {"failed", summary.failures}};
  run->report()["timings_s"]["flight"] = summary.mean_time_s;
  run->AddFile("config.resolved.yaml", text);
  run->AddFile("monte_carlo.json", FormatJson(ToJson(summary)));
  const std::string table = FormatTable(summary, name);
  run->AddFile("table.txt", table);
  for (const auto& [file, series] :
       {std::pair("trajectory_nees.txt", FormatTrajectoryNees(summary)),
        {"boresight_errors.txt", FormatBoresightErrors(records)}}) {
    if (!series.empty()) run->AddFile(file, series);
  }
  AddPlots(summary, records, name, run);
  fmt::print("{}", table);
}

void AddMonteCarlo(CLI::App* program, Action* action) {
  auto options = std::make_shared<MonteCarloArguments>();
  CLI::App* app = program->add_subcommand(
      "monte-carlo",
      "Simulates a scenario many times and tests the covariances against the true errors");
  app->add_option("SCENARIO", options->scenario, "Scenario file or name of a shipped scenario")
      ->required();
  AddChanges(app, "the scenario", "gnss.rate_hz=5", &options->common);
  app->add_option("--flights", options->flights, "Number of simulated flights")
      ->check(WholeNumber(1, kMostFlights))
      ->capture_default_str();
  app->add_option("--seed", options->first_seed,
                  "Seed of the first flight; each further flight adds 1")
      ->check(WholeNumber(0))
      ->capture_default_str();
  app->add_flag("--without-pairs", options->without_pairs,
                "Uses INS/GNSS data only, as dn smooth does, without boresight");
  app->add_option("--epoch-spacing", options->epoch_spacing_s,
                  "Spacing of the epochs at which the trajectory is tested [s]")
      ->check(PositiveNumber())
      ->capture_default_str();
  app->add_option("--draw-unmodelled", options->unmodelled,
                  "Draws every effect that the model leaves out for each flight, from its prior "
                  "times this factor, and tests the reported covariances. Default: no effects, and "
                  "the covariances of the pure model")
      ->check(PositiveNumber());
  app->add_option("--shard", options->shard,
                  "i/N: simulates only every N-th flight, starting with the i-th; dn merge joins "
                  "the shards")
      ->check(ShardText())
      ->capture_default_str();
  AddCommonOptions(app, &options->common, true);
  app->footer(
      "Each thread runs one flight at a time. Finished flights are kept in DIR/flights: the same\n"
      "command resumes an interrupted run, and a larger --flights extends a finished one.\n"
      "Example: dn monte-carlo uav3 --flights 100 --out consistency");
  app->callback([options, action] {
    *action = [options] {
      options->common.inputs = ScenarioInputs(options->scenario, options->common.changes);
      options->common.resumable = true;
      return Execute("monte-carlo", options->common, [&](Run& run) { MonteCarlo(*options, run); });
    };
  });
}

}  // namespace dn::apps
