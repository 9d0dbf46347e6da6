#include <dn/adjustment/unknown_noise.h>
#include <dn/config/yaml_value.h>
#include <dn/diagnosis/gap_output.h>
#include <dn/diagnosis/limits.h>
#include <dn/diagnosis/result_files.h>
#include <dn/files/scanners.h>
#include <dn/imu/unknown_imu.h>
#include <dn/names.h>
#include <dn/report/plot.h>
#include <dn/sim/scenario.h>
#include <dn/study/remedies.h>
#include <dn/study/study_output.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <optional>

#include "command.h"
#include "option_checks.h"
#include "series.h"
#include "study_lines.h"
#include "study_sweep.h"

namespace dn::apps {
namespace {

struct StudyArguments {
  CommonOptions common;
  std::string what;  ///< scenario or flight
  std::string estimate;
  std::string unmodelled;
  bool no_remedies = false;
  bool no_limits = false;
  std::uint64_t seed = 1;
  SweepOptions sweep;
  std::string lines;  ///< file with the candidate lines
};

/// Returns true for a shipped scenario or a YAML file with the key `plan`. A missing file also
/// counts as a scenario, since the error of the scenario reader lists the shipped ones.
bool IsScenario(const std::string& what) {
  std::error_code none;
  if (std::filesystem::is_directory(what, none)) return false;
  if (HasName(ScenarioNames(), what) || !std::filesystem::exists(what, none)) return true;
  const YamlValue root = ParseYaml(ScenarioText(what), what);
  return root.IsMap() && !root["plan"].absent();
}

StudyOptions MakeOptions(const StudyArguments& options, const Run& run) {
  StudyOptions study;
  study.design.threads = run.options().threads;
  study.design.seed = options.seed;
  study.design.estimate = options.estimate;
  study.design.unmodelled = options.unmodelled;
  study.design.interrupted = [] { return SignalReceived(); };
  study.remedies = !options.no_remedies;
  return study;
}

/// A study with the effects that such a flight could not detect.
struct StudyAndLimits {
  StudyResult study;
  std::vector<DetectionLimit> could_hide;  ///< empty with --no-limits or if not observable
};

StudyAndLimits StudyDesigned(const StudyArguments& options, const StudyDesign& design,
                             const StudyOptions& study, Run* run) {
  const Solution at_states = SolveAtStates(design, study.design.threads);
  StudyAndLimits result{Study(design, at_states), {}};
  const bool several = NumScanners(design.flight.config) > 1;
  if (options.no_limits || several || !result.study.observable()) return result;
  run->progress().Stage("detectability of effects");
  GapOptions gap;
  gap.threads = study.design.threads;
  gap.interrupted = study.design.interrupted;
  result.could_hide = DesignDetectionLimits(at_states, gap);
  return result;
}

StudyAndLimits StudyScenario(const StudyArguments& options, Run* run) {
  const Scenario scenario = ReadScenario(options.what, options.common.changes);
  run->progress().Stage("studying " + scenario.name);
  run->report()["seed"] = options.seed;
  const StudyOptions study = MakeOptions(options, *run);
  const StudyDesign design = MakeDesign(scenario, study.design);
  std::optional<RemedyTrials> remedies;
  if (study.remedies) remedies.emplace(scenario, design, study.design);
  StudyAndLimits result = StudyDesigned(options, design, study, run);
  if (remedies) {
    run->progress().Stage("trying remedies");
    remedies->Finish(&result.study);
  }
  run->AddFile("config.resolved.yaml", FormatScenario(scenario));
  return result;
}

StudyAndLimits StudyFlight(const StudyArguments& options, Run* run) {
  run->progress().Stage("reading " + options.what);
  FlightNeeds needs;
  needs.imu = needs.gnss = needs.pairs = needs.trajectory = true;
  needs.optional = true;
  Flight flight = ReadFlight(ReadFlightConfig(options.what, options.common.changes), needs);
  if (HasUnknownNoise(flight.config) && flight.config.imu->model.name == kUnknownGrade) {
    throw InvalidConfig(
        "imu.grade: unknown has no figures for a design; state imu.gyro and imu.accel, for example "
        "those that `dn smooth` estimates (config.resolved.yaml of its results)");
  }
  const std::string config = FormatFlightConfig(flight.config);
  run->report()["timings_s"]["read"] = flight.read_time_s;
  run->progress().Stage("studying " + flight.config.name);
  const StudyOptions study = MakeOptions(options, *run);
  StudyAndLimits result =
      StudyDesigned(options, MakeDesign(std::move(flight), study.design), study, run);
  run->AddFile("config.resolved.yaml", config);
  return result;
}

void AddSeries(const StudyResult& study, Run* run) {
  if (!study.trajectory.empty()) {
    run->AddFile("trajectory_sigma.txt", FormatTrajectorySigma(study.trajectory));
  }
  if (!study.correlations.empty()) {
    run->AddFile("correlations.txt", FormatCorrelations(study.correlations));
  }
}

void AddPlots(const StudyResult& study, Run* run) {
  for (const StudyPlot& plot : StudyPlots(study)) {
    const auto svg = DrawSvg(plot.title, plot.x_label, plot.panels, SignalReceived);
    if (!svg) {
      run->progress().Warn(
          "no plots: gnuplot is not installed or failed; study.json has the numbers");
      return;
    }
    run->AddFile(plot.file, *svg);
  }
}

void RunStudy(const StudyArguments& options, Run& run) {
  const auto [study, could_hide] =
      IsScenario(options.what) ? StudyScenario(options, &run) : StudyFlight(options, &run);
  run.progress().Stage("writing " + options.common.out.string());
  const std::string summary = StudySummary(study) + DetectionLimitsSummary(could_hide, true);
  Json json = StudyJson(study);
  if (!could_hide.empty()) json["could_still_hide"] = DetectionLimitsJson(could_hide);
  run.report()["flight"] = study.name;
  run.report()["counts"] = {{"imu epochs", study.imu_epochs},
                            {"gnss epochs", study.gnss_epochs},
                            {"pairs", study.pairs},
                            {"strips", study.geometry.strips.size()}};
  run.AddFile("study.json", FormatJson(json));
  run.AddFile("summary.txt", summary);
  AddSeries(study, &run);
  AddPlots(study, &run);
  fmt::print("{}", summary);
  if (study.observable()) return;
  throw FailedWithResults("not_observable", fmt::format("not observable: {}",
                                                        fmt::join(UnobservableWords(study), "; ")));
}

void AddStudyOptions(CLI::App* app, StudyArguments* options) {
  CLI::Option* what = app->add_option(
      "FLIGHT", options->what,
      "Scenario file, name of a shipped scenario, flight folder or YAML file of a flight");
  CLI::Option* changes =
      AddChanges(app, "the scenario or flight.yaml", "gnss.rate_hz=5", &options->common);
  app->add_option(
      "--estimate", options->estimate,
      "Comma-separated unknowns in addition to the boresight, as in `estimate` of flight.yaml. "
      "Default: those of the flight");
  app->add_option("--unmodelled", options->unmodelled,
                  "Sizes of the effects that the model leaves out, as in flight.yaml; none: the "
                  "pure model. Default: those of the flight");
  app->add_option("--seed", options->seed,
                  "Seed of the turbulence and the pair selection of a scenario")
      ->check(WholeNumber(0))
      ->capture_default_str();
  app->add_flag("--no-remedies", options->no_remedies,
                "Skips the trial of scenario changes that would improve weak directions");
  app->add_flag("--no-limits", options->no_limits,
                "Skips the minimal detectable bias of each unmodelled effect");
  CLI::Option* sweep =
      app->add_option("--sweep", options->sweep.file,
                      "YAML file with a base scenario and values of its keys; each combination is "
                      "studied and gives one row of sweep.csv");
  app->add_option("--shard", options->sweep.shard,
                  "i/N: studies only every N-th design of a sweep, starting with the i-th; dn "
                  "merge joins the shards")
      ->check(ShardText())
      ->needs(sweep)
      ->capture_default_str();
  CLI::Option* lines = app->add_option(
      "--optimise", options->lines,
      "YAML file with a base scenario, candidate lines and target sigmas; finds the "
      "shortest flight over a subset of the lines that meets them");
  what->excludes(sweep)->excludes(lines);
  sweep->excludes(lines);
  changes->excludes(sweep)->excludes(lines);
  AddCommonOptions(app, &options->common, true);
}

Inputs StudyInputs(const StudyArguments& options) {
  if (!options.what.empty()) {
    const std::vector<std::string>& changes = options.common.changes;
    return std::filesystem::is_directory(options.what) ? FlightInputs(options.what, changes)
                                                       : ScenarioInputs(options.what, changes);
  }
  Inputs inputs;
  inputs.files.emplace_back(options.sweep.file.empty() ? options.lines : options.sweep.file);
  return inputs;
}

void RunOne(const StudyArguments& options, Run& run) {
  if (!options.lines.empty()) return RunLineChoice({options.lines, options.seed}, run);
  if (!options.sweep.file.empty()) return RunSweep(options.sweep, run);
  RunStudy(options, run);
}

}  // namespace

void AddStudy(CLI::App* program, Action* action) {
  auto options = std::make_shared<StudyArguments>();
  CLI::App* app = program->add_subcommand(
      "study",
      "Computes covariances, correlations and observability of a flight or scenario; needs no "
      "measured values");
  AddStudyOptions(app, options.get());
  app->footer(
      "If the design leaves an unknown undetermined, the exit code is 1.\n"
      "docs/guides/study.md explains the results.\n"
      "Example: dn study lar2 --out study\n"
      "         dn study --sweep lines_and_grades.yaml --out sweep\n"
      "         dn study --optimise candidates.yaml --out plan");
  app->callback([options, action] {
    if (options->what.empty() && options->sweep.file.empty() && options->lines.empty()) {
      throw CLI::RequiredError("FLIGHT");
    }
    *action = [options] {
      options->common.inputs = StudyInputs(*options);
      options->common.resumable = !options->sweep.file.empty();
      return Execute("study", options->common, [&](Run& run) { RunOne(*options, run); });
    };
  });
}

}  // namespace dn::apps
