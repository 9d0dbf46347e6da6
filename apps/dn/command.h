#pragma once

#include <dn/error.h>
#include <dn/files/atomic_file.h>
#include <dn/report/json.h>
#include <dn/stopwatch.h>

#include <CLI/CLI.hpp>
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

/// Options that every subcommand has.
struct CommonOptions {
  int threads = 1;
  bool json_progress = false;
  std::filesystem::path out;
  std::vector<std::string> changes;  ///< key=value of each --set; empty without a YAML file
  Inputs inputs;                     ///< files and folders that the command reads
  bool writes_flight = false;        ///< the result is a flight folder
  bool resumable = false;            ///< the command can be resumed after an interruption
};

/// Ends a run whose results are written but must not count as a success: the exit code is 1.
class FailedWithResults : public std::runtime_error {
 public:
  FailedWithResults(std::string kind, const std::string& message)
      : std::runtime_error(message), kind_(std::move(kind)) {}
  const std::string& kind() const { return kind_; }

 private:
  std::string kind_;
};

/// Returns the error message with its file, line and column appended, if known.
std::string FormatWithLocation(const InvalidInput& error);

/// Writes a line to stderr. A write error is ignored.
void Say(const std::string& line);

/// Prints a JSON line on stderr. JSON has its own notation for control characters.
void SayJson(const Json& line);

/// Flushes stdout. If that fails, e.g. on a full disk, prints an error line and returns false.
bool FlushStandardOutput(const std::string& command);

/// Stores the command line for report.json.
void RememberCommandLine(int argc, char** argv);

/// One run of a subcommand with its output directory and its report.
class Run {
 public:
  Run(std::string command, const CommonOptions& options);

  /// Stages a file for --out. Does nothing without --out.
  void AddFile(const std::string& name, const std::string& content);

  /// Returns the output directory, for library functions that write into it. Throws InvalidConfig
  /// without --out.
  OutputDirectory& files();

  /// Locks --out for this run and removes the files of an earlier result. Throws if results there
  /// would damage inputs, or if another run uses the directory.
  void TakeOutput();

  /// Declares that this run reads the flight's point clouds, so that report.json lists them.
  void ReadsStrips();

  /// Publishes the staged files, report.json and report.html. Throws Interrupted if a signal
  /// arrived before.
  void Publish();

  /// Publishes report.json with its present content and the error, and a page of it if the data,
  /// once read, caused the error. Does nothing unless TakeOutput was called.
  void PublishFailure(const std::string& kind, const std::string& message);

  Json& report() { return report_; }
  Progress& progress() { return progress_; }
  const CommonOptions& options() const { return options_; }
  const std::string& command() const { return command_; }

 private:
  Json EmptyReport() const;
  Json FailureReport(Json so_far, const std::string& kind, const std::string& message) const;
  void AddPage();

  std::string command_;
  CommonOptions options_;
  Json report_;
  Progress progress_;
  std::unique_ptr<OutputDirectory> files_;
  Stopwatch watch_;
};

/// Runs the body. Reports an exception as an error line on stderr and in report.json. Returns the
/// exit code: 0 success, 1 failed, 2 usage or configuration, 130 interrupted.
int Execute(const std::string& command, const CommonOptions& options,
            const std::function<void(Run&)>& body);

/// Adds --threads and --json-progress to a subcommand.
void AddThreads(CLI::App* app, CommonOptions* options);

/// Adds --threads, --json-progress and --out. out_required: --out is mandatory.
void AddCommonOptions(CLI::App* app, CommonOptions* options, bool out_required);

/// Adds --set to a command that reads the YAML file `of`, and returns the option; `example` is a
/// key=value for the help.
CLI::Option* AddChanges(CLI::App* app, const std::string& of, const std::string& example,
                        CommonOptions* options);

/// Adds the argument FLIGHT and --set.
void AddFlightOptions(CLI::App* app, std::string* flight, CommonOptions* options);
/// Adds --scanner, which selects one scanner of flight.yaml as --set scanner=NAME does.
void AddScanner(CLI::App* app, CommonOptions* options);
/// Adds --unmodelled, which replaces the section of flight.yaml as --set does.
void AddUnmodelled(CLI::App* app, CommonOptions* options);

/// Each Add... function below adds one subcommand to the program. If the command line names that
/// subcommand, parsing stores its action in *action; main then runs it.
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
