#include <dn/blind_check/blind_score.h>
#include <dn/error.h>
#include <dn/names.h>
#include <dn/report/plot.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "blind_flight_run.h"
#include "command.h"
#include "config_text.h"
#include "fleet.h"
#include "option_checks.h"
#include "series_records.h"
#include "sha256.h"

namespace dn::apps {
namespace {

struct BlindCheckArguments {
  CommonOptions common;
  int flights = 100;
  std::uint64_t seed = 1;
  std::vector<std::string> scenarios = BlindScenarioNames();
  std::string gap_options = "quick";
  std::string shard = "1/1";
  std::string only;  ///< word of a BlindContent, or empty for a random content
  double size_factor = 1.0;
  std::string physics;  ///< file of ParsePhysics, or empty
  bool discard_flights = false;
};

std::vector<std::string> ReadGapOptions(const std::string& word) {
  if (word == "quick") return {"--quick"};
  if (word == "screen") return {"--screen-only"};
  return {};
}

/// Lists the base scenarios: shipped ones by name, others and changed ones by name and text.
Json ScenariosJson(const std::vector<std::string>& scenarios,
                   const std::vector<std::string>& changes) {
  const std::vector<std::string> shipped = ScenarioNames();
  Json names = Json::array();
  for (const std::string& scenario : scenarios) {
    // This reports an invalid scenario before the first flight.
    const Scenario changed = ReadScenario(scenario, changes);
    ExpectOneScanner(changed, "dn blind-check");
    if (!changes.empty()) {
      names.push_back({{scenario, FormatScenario(changed)}});
    } else if (HasName(shipped, scenario)) {
      names.push_back(scenario);
    } else {
      names.push_back({{scenario, ScenarioText(scenario)}});
    }
  }
  return names;
}

std::string FirstFailure(const BlindRecord& record) {
  for (const std::string& failure :
       {record.diagnosis.failure, record.calibrated.failure, record.adapted.failure}) {
    if (!failure.empty()) return failure;
  }
  return {};
}

std::string PhysicsText(const BlindCheckArguments& options) {
  return options.physics.empty() ? std::string() : ReadConfigText(options.physics);
}

BlindSuite MakeSuite(const BlindCheckArguments& options, const std::string& physics) {
  BlindSuite suite{options.seed, options.scenarios};
  if (!options.only.empty()) suite.only = RecordContent(options.only);
  suite.size_factor = options.size_factor;
  if (!options.physics.empty()) suite.physics = ParsePhysics(physics, options.physics);
  suite.changes = options.common.changes;
  return suite;
}

std::vector<BlindRecord> Fly(const BlindCheckArguments& options, const BlindSuite& suite,
                             const RecordFolder& folder, const RecordReader<BlindRecord>& reader,
                             const std::vector<std::uint64_t>& numbers, Run* run) {
  const BlindRunOptions how{options.common.out, ReadGapOptions(options.gap_options),
                            options.discard_flights};
  std::vector<BlindRecord> records(numbers.size());
  const auto fly = [&](std::size_t k) {
    std::optional<BlindRecord> record = folder.Read(numbers[k], reader);
    if (!record) {
      record = RunBlindFlight(DrawBlindFlight(suite, static_cast<int>(numbers[k])), how);
      folder.Write(numbers[k], ToJson(*record));
    }
    records[k] = std::move(*record);
  };
  const auto on_finished = [&](std::size_t k) {
    const std::string failure = FirstFailure(records[k]);
    if (!failure.empty()) run->progress().Warn(fmt::format("flight {}: {}", numbers[k], failure));
  };
  SimulateAll(numbers.size(), run, fly, on_finished);
  return records;
}

void BlindCheck(const BlindCheckArguments& options, Run& run) {
  const std::string physics = PhysicsText(options);
  const BlindSuite suite = MakeSuite(options, physics);
  const Json made_from = {{"seed", options.seed},
                          {"scenarios", ScenariosJson(options.scenarios, options.common.changes)},
                          {"gap_options", options.gap_options},
                          {"only", options.only},
                          {"size_factor", options.size_factor},
                          {"physics", physics},
                          {"version", DN_VERSION},
                          {"program", ProgramHash()}};
  const Series series{"blind-check", 1, static_cast<std::uint64_t>(options.flights),
                      ParseShard(options.shard), RecordFolder::MadeFromHash(made_from)};
  for (const char* name : {"flights", "truth", "runs"}) ExpectRealFolder(options.common.out / name);
  const RecordFolder folder(options.common.out / RecordFolderName(series.command), made_from);
  const std::vector<BlindRecord> records =
      Fly(options, suite, folder, BlindRecordReader(made_from), series.Numbers(), &run);
  run.report()["seed"] = options.seed;
  run.report()["series"] = SeriesToJson(series);
  AddBlindCheckResults(made_from, records, &run);
}

PlotPanel ReliabilityPanel(const BlindScore& score) {
  PlotSeries seen{"observed", {}, PlotStyle::kPoints};
  PlotSeries interval_95{"95 % confidence interval", {}, PlotStyle::kSpans};
  for (const ReliabilityBin& bin : score.reliability) {
    if (bin.true_causes.of == 0) continue;
    const Interval interval = bin.true_causes.interval_95();
    seen.points.emplace_back(bin.stated, bin.true_causes.value());
    interval_95.points.emplace_back(bin.stated, interval.low);
    interval_95.points.emplace_back(bin.stated, interval.high);
  }
  const PlotSeries calibrated{"calibrated", {{0.0, 0.0}, {1.0, 1.0}}, PlotStyle::kLines};
  return {"observed frequency", {interval_95, seen, calibrated}};
}

PlotPanel BoresightPanel(const std::string& label, const std::vector<BlindRecord>& records,
                         Outcome<BlindCalibration> BlindRecord::*outcome) {
  PlotSeries errors{"largest |error| / sigma", {}, PlotStyle::kPoints};
  PlotSeries limit{"5", {}, PlotStyle::kLines};
  for (const BlindRecord& record : records) {
    const auto& calibration = (record.*outcome).result;
    if (calibration) errors.points.emplace_back(record.number, calibration->worst());
    limit.points.emplace_back(record.number, 5.0);
  }
  return {label, {errors, limit}};
}

void AddPlots(const BlindScore& score, const std::vector<BlindRecord>& records, Run* run) {
  const auto reliability =
      DrawSvg("posterior of a cause: stated probability and observed frequency", "stated",
              {ReliabilityPanel(score)}, SignalReceived);
  if (!reliability) {
    run->progress().Warn("no plots: gnuplot is not installed or failed");
    return;
  }
  run->AddFile("reliability.svg", *reliability);
  const auto errors = DrawSvg("boresight errors in sigmas", "flight",
                              {BoresightPanel("as assumed", records, &BlindRecord::calibrated),
                               BoresightPanel("adapted", records, &BlindRecord::adapted)},
                              SignalReceived);
  if (errors) run->AddFile("boresight_errors.svg", *errors);
}

std::string ConfigText(const Json& made_from) {
  std::string text;
  for (const auto& [key, value] : made_from.items()) text += key + ": " + value.dump() + "\n";
  return text;
}

}  // namespace

void AddBlindCheckResults(const Json& made_from, const std::vector<BlindRecord>& records,
                          Run* run) {
  const BlindScore score = ScoreBlindFlights(records);
  run->report()["counts"] = {{"flights", score.flights}, {"failures", score.failures.size()}};
  run->report()["timings_s"]["gap, median"] = score.diagnosis_time_s.median;
  run->report()["timings_s"]["gap, upper quartile"] = score.diagnosis_time_s.high;
  run->report()["timings_s"]["calibrate, median"] = score.calibration_time_s.median;
  run->AddFile("config.resolved.yaml", ConfigText(made_from));
  run->AddFile("blind_check.json", FormatJson(ToJson(score)));
  run->AddFile("flights.csv", FormatCsv(records));
  const std::string table = FormatTable(score);
  run->AddFile("table.txt", table);
  AddPlots(score, records, run);
  fmt::print("{}", table);
}

void AddBlindCheck(CLI::App* program, Action* action) {
  auto options = std::make_shared<BlindCheckArguments>();
  CLI::App* app = program->add_subcommand(
      "blind-check",
      "Simulates flights with random effects, diagnoses each with dn gap and scores the diagnoses");
  app->add_option("--flights", options->flights, "Number of simulated flights")
      ->check(WholeNumber(1, kMostFlights))
      ->capture_default_str();
  app->add_option("--seed", options->seed, "Seed of the random flights and their effects")
      ->check(WholeNumber(0))
      ->capture_default_str();
  app->add_option("--scenarios", options->scenarios,
                  "Comma-separated base scenarios of the flights, names of shipped ones or files")
      ->delimiter(',')
      ->capture_default_str();
  app->add_option("--gap-options", options->gap_options,
                  "Depth of the diagnosis by dn gap: full, quick (--quick) or screen "
                  "(--screen-only)")
      ->check(AllowedValues({"full", "quick", "screen"}))
      ->capture_default_str();
  app->add_option("--shard", options->shard,
                  "i/N: simulates only every N-th flight, starting with the i-th; dn merge joins "
                  "the shards")
      ->check(ShardText())
      ->capture_default_str();
  CLI::Option* only =
      app->add_option(
             "--only", options->only,
             "Content of every flight: no effect, one, two, three, or one outside the table "
             "of effects")
          ->check(AllowedValues({"nothing", "one", "two", "three", "outsider"}));
  app->add_flag_callback(
         "--left-out", [options] { options->only = Word(BlindContent::kLeftOut); },
         "Every flight contains one effect, which dn gap must not consider")
      ->excludes(only);
  app->add_option("--size-factor", options->size_factor,
                  "Factor on the sizes of the effects of the table")
      ->check(PositiveNumber())
      ->capture_default_str();
  app->add_option("--physics", options->physics,
                  "YAML file with effects outside the table, used instead of the built-in ones "
                  "(docs/reference/physics.md)");
  app->add_flag("--discard-flights", options->discard_flights,
                "Removes each flight folder (about 20 MB) once the flight is recorded");
  AddChanges(app, "every scenario", "plan.vibration=none", &options->common);
  AddCommonOptions(app, &options->common, true);
  app->footer(
      "Each thread runs one flight at a time. DIR/flights has the flights, DIR/truth their\n"
      "contents and DIR/runs their results. Recorded flights are kept in DIR/records: the same\n"
      "command resumes an interrupted run, and a larger --flights extends a finished one.\n"
      "To run flight 7 of 40 alone, give --flights 40 --shard 7/40.\n"
      "Example: dn blind-check --flights 100 --out blind --seed 3");
  app->callback([options, action] {
    *action = [options] {
      for (const std::string& scenario : options->scenarios) {
        const Inputs inputs = ScenarioInputs(scenario, options->common.changes);
        std::copy(inputs.files.begin(), inputs.files.end(),
                  std::back_inserter(options->common.inputs.files));
      }
      if (!options->physics.empty()) options->common.inputs.files.push_back(options->physics);
      options->common.resumable = true;
      return Execute("blind-check", options->common, [&](Run& run) { BlindCheck(*options, run); });
    };
  });
}

}  // namespace dn::apps
