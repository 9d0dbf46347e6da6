#pragma once

#include <csignal>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace dn::testing {

/// Output and exit status of one run of the program dn.
struct ProgramRun {
  int exit_code = -1;  ///< -1: ended by `signal`
  int signal = 0;
  std::string out;
  std::string err;
  double end_after_signal_s = 0.0;
};

// The shadow memory of the address sanitizer needs terabytes of address space.
#if defined(__SANITIZE_ADDRESS__)
constexpr bool kMemoryCanBeLimited = false;
#elif defined(__has_feature)
constexpr bool kMemoryCanBeLimited = !__has_feature(address_sanitizer);
#else
constexpr bool kMemoryCanBeLimited = true;
#endif

struct ProgramOptions {
  std::vector<std::string> arguments;
  /// File for stdout, instead of ProgramRun::out.
  std::optional<std::string> out_file;
  /// File for stderr, instead of ProgramRun::err.
  std::optional<std::string> err_file;
  /// Streams that are closed when the program starts.
  std::vector<int> closed_streams;
  /// Size limit of files that the program writes, which acts like a full disk.
  std::optional<long> max_file_bytes;
  /// Limit of the program's address space; ignored unless kMemoryCanBeLimited.
  std::optional<long> max_memory_bytes;
  /// Limit of processes and threads of the user. Since it does not apply to root, root runs the
  /// program as user nobody.
  std::optional<long> max_threads;
  /// Signal that is sent once stderr contains `signal_after`, as often as given below.
  int signal = 0;
  int signal_count = 1;
  std::string signal_after;
  /// Called instead of sending the signal, with the program's process id.
  std::function<void(int)> at_signal;
};

/// Runs build/.../bin/dn. A run above two minutes is killed, which shows in ProgramRun::signal.
ProgramRun RunProgram(const ProgramOptions& options);
ProgramRun RunProgram(const std::vector<std::string>& arguments);

/// These functions return the flight that the test cli.simulate made of short.yaml, and the results
/// of cli.check, cli.smooth, cli.calibrate and cli.gap on it. Tests must not write into them.
std::filesystem::path ShortFlight();
std::filesystem::path CheckResult();
std::filesystem::path SmoothResult();
std::filesystem::path CalibrateResult();
std::filesystem::path GapResult();  ///< result of cli.gap with --screen-only
std::filesystem::path ShortScenario();

std::string FileContent(const std::filesystem::path& file);

/// Returns the text without the lines that contain `part`.
std::string WithoutLines(const std::string& text, const std::string& part);

/// Returns the sorted names in a folder, including hidden ones.
std::vector<std::string> NamesIn(const std::filesystem::path& folder);

}  // namespace dn::testing
