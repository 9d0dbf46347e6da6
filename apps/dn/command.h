#pragma once

#include <dn/error.h>
#include <dn/flight/atomic_file.h>
#include <dn/report/json.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "interruption.h"
#include "output_folder.h"
#include "progress.h"

namespace dn::apps {

/// Options that every subcommand takes.
struct CommonOptions {
  int threads = 1;
  bool json_progress = false;
  std::filesystem::path out;
  std::vector<std::string> changes;  ///< --set, of a command that reads YAML
  Inputs inputs;                     ///< what the command reads; filled in before it runs
  bool makes_flight = false;         ///< its result is a flight folder
  bool keeps_records = false;        ///< the same command goes on where it was interrupted
};

/// The work ended with results that must not pass for a success: they are written, the exit code
/// is 1.
class FailedWithResults : public std::runtime_error {
 public:
  FailedWithResults(std::string kind, const std::string& message)
      : std::runtime_error(message), kind_(std::move(kind)) {}
  const std::string& kind() const { return kind_; }

 private:
  std::string kind_;
};

/// What an error says, with the place that it names.
std::string WithLocation(const InvalidInput& error);

/// A line on stderr, where it can be written.
void Say(const std::string& line);

/// What was printed may wait in a buffer that cannot be written, on a full disk say: false, and an
/// error line.
bool FlushStandardOutput(const std::string& command);

/// Keeps the command line for report.json.
void RememberCommandLine(int argc, char** argv);

/// One run of a subcommand: what it writes into its output directory, and its report.
class Run {
 public:
  Run(std::string command, const CommonOptions& options);

  /// Stages a file of --out. Without --out nothing is written.
  void AddFile(const std::string& name, const std::string& content);

  /// The output directory itself, for a library that writes into one. Throws without --out.
  OutputDirectory& files();

  /// Takes --out for this run: throws where results in it would do harm or another run holds it,
  /// and removes the files of an earlier result.
  void TakeOutput();

  /// The point clouds of the flight are among what this run reads.
  void ReadsStrips();

  /// Publishes what was staged, report.json and report.html. Throws Interrupted when a signal came
  /// before.
  void Publish();

  /// Publishes nothing but report.json, if --out was taken: what it holds so far, and the error.
  void PublishFailure(const std::string& kind, const std::string& message);

  Json report;
  Progress progress;
  const CommonOptions& options() const { return options_; }
  const std::string& command() const { return command_; }

 private:
  Json EmptyReport() const;
  Json FailureReport(Json so_far, const std::string& kind, const std::string& message) const;
  void AddPage();

  std::string command_;
  CommonOptions options_;
  std::unique_ptr<OutputDirectory> files_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Runs the body and turns what it throws into the error line on stderr, report.json and the exit
/// code: 0, 1 failed, 2 usage or configuration, 130 interrupted.
int Execute(const std::string& command, const CommonOptions& options,
            const std::function<void(Run&)>& body);

/// Adds --threads and --json-progress to a subcommand.
void AddThreads(CLI::App* app, CommonOptions* options);

/// Adds --out to them. out_required: as for commands whose result is files.
void AddCommonOptions(CLI::App* app, CommonOptions* options, bool out_required);

/// --set of a command that reads the YAML file `of`.
void AddChanges(CLI::App* app, const std::string& of, const std::string& example,
                CommonOptions* options);

/// Adds the argument FLIGHT and --set.
void AddFlightOptions(CLI::App* app, std::string* flight, CommonOptions* options);

/// Subcommands: each adds itself to the program and puts its action where main calls it.
using Action = std::function<int()>;
void AddAllan(CLI::App* program, Action* action);
void AddInit(CLI::App* program, Action* action);
void AddCheck(CLI::App* program, Action* action);
void AddSimulate(CLI::App* program, Action* action);
void AddSmooth(CLI::App* program, Action* action);
void AddCalibrate(CLI::App* program, Action* action);
void AddMonteCarlo(CLI::App* program, Action* action);
void AddGap(CLI::App* program, Action* action);
void AddGeoref(CLI::App* program, Action* action);
void AddMatch(CLI::App* program, Action* action);
void AddStudy(CLI::App* program, Action* action);
void AddBlindCheck(CLI::App* program, Action* action);
void AddMerge(CLI::App* program, Action* action);
void AddReport(CLI::App* program, Action* action);
void AddCompletion(CLI::App* program, Action* action);

}  // namespace dn::apps
