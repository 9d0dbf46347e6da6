#include <dn/calibration/adjust.h>
#include <dn/error.h>
#include <dn/montecarlo/summary.h>
#include <dn/report/plot.h>
#include <dn/sim/scenario.h>
#include <fmt/format.h>

#include <atomic>
#include <exception>
#include <fstream>
#include <iterator>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>

#include "command.h"
#include "option_checks.h"

namespace dn::apps {
namespace {

namespace fs = std::filesystem;

struct Options {
  CommonOptions common;
  std::string scenario;
  int flights = 100;
  std::uint64_t first_seed = 1;
  bool without_pairs = false;
  double epoch_spacing_s = 1.0;
};

/// The records of finished flights, one file each, so that an interrupted run can be taken up.
class RecordFolder {
 public:
  // Throws InvalidConfig when the folder holds the records of something else.
  RecordFolder(fs::path folder, const Json& made_from) : folder_(std::move(folder)) {
    const fs::path key = folder_ / "made_from.json";
    const std::string text = FormatJson(made_from);
    if (fs::exists(key) && ReadText(key) != text) {
      throw InvalidConfig(folder_.string() +
                          " holds flights of another scenario, version or option (see " +
                          key.string() + "); give another --out, or delete it");
    }
    fs::create_directories(folder_);
    RemoveUnfinished();
    WriteFileAtomically(key, text);
  }

  std::optional<FlightRecord> Read(std::uint64_t seed) const {
    const fs::path file = FileOf(seed);
    if (!fs::exists(file)) return std::nullopt;
    try {
      return FlightRecordFromJson(Json::parse(ReadText(file)));
    } catch (const Json::exception& error) {
      throw InvalidInput(std::string("not the record of a flight (") + error.what() +
                             "); delete the file to fly it again",
                         {file.string()});
    }
  }

  void Write(const FlightRecord& record) const {
    WriteFileAtomically(FileOf(record.seed), ToJson(record).dump() + "\n");
  }

 private:
  // Temporary files of runs that were killed; the lock of --out keeps others out of here.
  void RemoveUnfinished() const {
    std::vector<fs::path> unfinished;
    for (const auto& entry : fs::directory_iterator(folder_)) {
      const std::string name = entry.path().filename().string();
      if (name.starts_with('.') && name.ends_with(".part")) unfinished.push_back(entry.path());
    }
    for (const fs::path& file : unfinished) fs::remove(file);
  }

  static std::string ReadText(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  }
  fs::path FileOf(std::uint64_t seed) const { return folder_ / fmt::format("{:06}.json", seed); }

  fs::path folder_;
};

/// Flies the missing seeds on several threads, one flight each.
class Fleet {
 public:
  Fleet(const Options& options, const Scenario& scenario, const RecordFolder& folder, Run* run)
      : options_(options), scenario_(scenario), folder_(folder), run_(run) {}

  std::vector<FlightRecord> Fly() {
    records_.resize(static_cast<std::size_t>(options_.flights));
    std::vector<std::thread> threads;
    const int workers = std::min(run_->options().threads, options_.flights);
    threads.reserve(static_cast<std::size_t>(workers));
    try {
      for (int i = 1; i < workers; ++i) threads.emplace_back([this] { Work(); });
    } catch (const std::system_error&) {
      run_->progress.Warn(
          fmt::format("only {} of {} threads can be started", threads.size() + 1, workers));
    }
    Work();
    for (std::thread& thread : threads) thread.join();
    if (error_) std::rethrow_exception(error_);
    if (Interrupted()) throw dn::Interrupted();
    return std::move(records_);
  }

 private:
  void Work() {
    for (;;) {
      const std::size_t k = next_++;
      if (k >= records_.size() || Interrupted() || failed_) return;
      try {
        FlyOne(k);
      } catch (const dn::Interrupted&) {
        return;
      } catch (...) {
        const std::lock_guard lock(mutex_);
        failed_ = true;
        if (!error_) error_ = std::current_exception();
        return;
      }
    }
  }

  void FlyOne(std::size_t k) {
    const std::uint64_t seed = options_.first_seed + k;
    std::optional<FlightRecord> record = folder_.Read(seed);
    if (!record) {
      FlightRecordOptions options;
      options.with_pairs = !options_.without_pairs;
      options.epoch_spacing_s = options_.epoch_spacing_s;
      options.interrupted = [] { return Interrupted(); };
      record = RunFlight(scenario_, seed, options);
      folder_.Write(*record);
    }
    const std::lock_guard lock(mutex_);
    if (!record->failure.empty()) {
      run_->progress.Warn(fmt::format("seed {}: {}", seed, record->failure));
    }
    records_[k] = std::move(*record);
    run_->progress.Stage("flights", fmt::format("{} of {}", ++done_, records_.size()));
  }

  const Options& options_;
  const Scenario& scenario_;
  const RecordFolder& folder_;
  Run* run_;
  std::mutex mutex_;
  std::vector<FlightRecord> records_;
  std::atomic<std::size_t> next_{0};
  std::atomic<bool> failed_{false};
  std::size_t done_ = 0;
  std::exception_ptr error_;
};

PlotSeries Level(const std::string& label, double value, const std::vector<double>& t_s) {
  return {label, {{t_s.front(), value}, {t_s.back(), value}}, true};
}

void AddPlots(const MonteCarloSummary& summary, const std::vector<FlightRecord>& records,
              const std::string& scenario, Run* run) {
  std::vector<PlotPanel> panels;
  for (const TrajectoryConsistency& c : summary.trajectory) {
    if (c.t_s.empty()) continue;
    PlotSeries nees{"NEES / 3", {}, true};
    for (std::size_t k = 0; k < c.t_s.size(); ++k) {
      nees.points.emplace_back(c.t_s[k], c.nees_per_dof[k]);
    }
    panels.push_back(
        {c.quantity,
         {nees, Level("99 % low", c.band.low, c.t_s), Level("99 % high", c.band.high, c.t_s)}});
  }
  const std::string title =
      fmt::format("{}: trajectory NEES over {} flights", scenario, summary.flights);
  const auto trajectory = DrawSvg(title, "time since the first node [s]", panels, Interrupted);
  if (!trajectory) {
    run->progress.Warn("no plots: gnuplot is not installed or failed");
    return;
  }
  run->AddFile("trajectory_nees.svg", *trajectory);
  if (!summary.with_pairs) return;
  const char* names[] = {"roll", "pitch", "yaw"};
  std::vector<PlotPanel> angles;
  for (int i = 0; i < 3; ++i) {
    PlotSeries errors{"error / sigma", {}, false};
    std::vector<double> seeds;
    for (const FlightRecord& record : records) {
      if (!record.failure.empty()) continue;
      const double sigma = std::sqrt(record.boresight_covariance_rad2(i, i));
      seeds.push_back(static_cast<double>(record.seed));
      errors.points.emplace_back(seeds.back(), record.boresight_error_rad[i] / sigma);
    }
    angles.push_back({names[i], {errors, Level("+3", 3.0, seeds), Level("-3", -3.0, seeds)}});
  }
  if (const auto svg =
          DrawSvg(scenario + ": boresight errors in sigmas", "seed", angles, Interrupted)) {
    run->AddFile("boresight_errors.svg", *svg);
  }
}

void MonteCarlo(const Options& options, Run& run) {
  const Scenario scenario = ReadScenario(options.scenario);
  const Json made_from = {{"scenario", ScenarioText(options.scenario)},
                          {"with_pairs", !options.without_pairs},
                          {"epoch_spacing_s", options.epoch_spacing_s},
                          {"version", DN_VERSION}};
  const RecordFolder folder(options.common.out / "flights", made_from);
  const std::vector<FlightRecord> records = Fleet(options, scenario, folder, &run).Fly();
  const MonteCarloSummary summary = Summarise(records);
  run.report["seed"] = options.first_seed;
  run.report["scenario"] = scenario.name;
  run.report["counts"] = {{"flights", summary.flights}, {"failed", summary.failures}};
  run.AddFile("config.resolved.yaml", ScenarioText(options.scenario));
  run.AddFile("monte_carlo.json", FormatJson(ToJson(summary)));
  const std::string table = FormatTable(summary, scenario.name);
  run.AddFile("table.txt", table);
  AddPlots(summary, records, scenario.name, &run);
  fmt::print("{}", table);
}

}  // namespace

void AddMonteCarlo(CLI::App* program, Action* action) {
  auto options = std::make_shared<Options>();
  CLI::App* app = program->add_subcommand(
      "monte-carlo",
      "Flies a scenario many times and judges the covariances by the errors against the truth");
  app->add_option("SCENARIO", options->scenario, "Scenario file, or the name of a shipped one")
      ->required();
  app->add_option("--flights", options->flights, "Number of flights")
      ->check(WholeNumber(1, 1000000))
      ->capture_default_str();
  app->add_option("--seed", options->first_seed, "Seed of the first flight; the others follow")
      ->check(WholeNumber(0))
      ->capture_default_str();
  app->add_flag("--without-pairs", options->without_pairs,
                "INS/GNSS only, as dn smooth: no boresight");
  app->add_option("--epoch-spacing", options->epoch_spacing_s,
                  "Spacing of the epochs at which the trajectory is judged [s]")
      ->check(PositiveNumber())
      ->capture_default_str();
  AddCommonOptions(app, &options->common, true);
  app->footer(
      "One flight runs on each thread. Finished flights stay in DIR/flights: the same command "
      "takes "
      "an\ninterrupted run up again, and with more --flights it adds to it.\n"
      "Example: dn monte-carlo uav3 --flights 100 --out consistency");
  app->callback([options, action] {
    *action = [options] {
      options->common.inputs = ScenarioInputs(options->scenario);
      return Execute("monte-carlo", options->common, [&](Run& run) { MonteCarlo(*options, run); });
    };
  });
}

}  // namespace dn::apps
