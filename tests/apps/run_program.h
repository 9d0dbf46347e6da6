#pragma once

#include <csignal>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace dn::testing {

/// What one run of the program dn left behind.
struct ProgramRun {
  int exit_code = -1;  ///< -1: ended by `signal`
  int signal = 0;
  std::string out;
  std::string err;
  double end_after_signal_s = 0.0;
};

struct ProgramOptions {
  std::vector<std::string> arguments;
  /// Where stdout goes instead of ProgramRun::out.
  std::optional<std::string> out_file;
  /// Where stderr goes instead of ProgramRun::err.
  std::optional<std::string> err_file;
  /// Streams that are closed when the program starts.
  std::vector<int> closed_streams;
  /// Largest file that the program may write, as on a full disk.
  std::optional<long> max_file_bytes;
  /// Memory that the program may map.
  std::optional<long> max_memory_bytes;
  /// Processes and threads that its user may have. They are not counted for root, who runs the
  /// program as nobody then.
  std::optional<long> max_threads;
  /// Signal sent, so many times, once stderr contains `signal_after`.
  int signal = 0;
  int signal_count = 1;
  std::string signal_after;
  /// Called in its place, with the program's process id.
  std::function<void(int)> at_signal;
};

/// Runs build/.../bin/dn. A run longer than two minutes is killed, and so seen as `signal`.
ProgramRun RunProgram(const ProgramOptions& options);
ProgramRun RunProgram(const std::vector<std::string>& arguments);

/// The flight that the test cli.simulate made of short.yaml, and the results of cli.check,
/// cli.smooth, cli.calibrate and cli.gap on it. Never written to.
std::filesystem::path ShortFlight();
std::filesystem::path CheckResult();
std::filesystem::path SmoothResult();
std::filesystem::path CalibrateResult();
std::filesystem::path GapResult();  ///< of cli.gap, screened only
std::filesystem::path ShortScenario();

std::string ContentOf(const std::filesystem::path& file);

/// A text without the lines that hold `part`.
std::string WithoutLines(const std::string& text, const std::string& part);

/// Names in a folder, hidden ones too, sorted.
std::vector<std::string> NamesIn(const std::filesystem::path& folder);

}  // namespace dn::testing
