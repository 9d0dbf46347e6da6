#pragma once

#include <csignal>
#include <filesystem>
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
};

struct ProgramOptions {
  std::vector<std::string> arguments;
  /// Where stdout goes instead of ProgramRun::out.
  std::optional<std::string> out_file;
  /// Largest file that the program may write, as on a full disk.
  std::optional<long> max_file_bytes;
  /// Signal sent once stderr contains `signal_after`.
  int signal = 0;
  std::string signal_after;
};

/// Runs build/.../bin/dn. A run longer than two minutes is killed, and so seen as `signal`.
ProgramRun RunProgram(const ProgramOptions& options);
ProgramRun RunProgram(const std::vector<std::string>& arguments);

/// The flight that the test cli.simulate made of short.yaml, and the results of cli.check,
/// cli.smooth and cli.calibrate on it. Never written to.
std::filesystem::path ShortFlight();
std::filesystem::path CheckResult();
std::filesystem::path SmoothResult();
std::filesystem::path CalibrateResult();
std::filesystem::path ShortScenario();

std::string ContentOf(const std::filesystem::path& file);

/// Names in a folder, hidden ones too, sorted.
std::vector<std::string> NamesIn(const std::filesystem::path& folder);

}  // namespace dn::testing
