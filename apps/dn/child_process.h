#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace dn::apps {

/// Path of the running program; still valid if its file has been replaced since the start.
inline constexpr const char* kThisProgram = "/proc/self/exe";

/// Exit code of a process that a signal killed, minus the number of the signal.
inline constexpr int kFirstSignal = 128;

/// Exit code and resource usage of a finished process.
struct ProcessUsage {
  int exit_code = -1;  ///< 128 + signal number if a signal killed the process
  double wall_s = 0.0;
  double cpu_s = 0.0;  ///< user and system, all threads
  double peak_rss_mib = 0.0;
};

/// Conditions under which a process is killed.
struct ProcessLimits {
  double longest_s = 1e9;                       ///< maximum run time
  std::function<bool()> interrupted = nullptr;  ///< polled; returns true to end the process
};

/// Runs a program with stdout and stderr in `output_file` and waits for it to end. The process is
/// ended by SIGTERM, so that it can remove its staged files, and two seconds later by SIGKILL. The
/// kernel sends SIGTERM if the calling thread dies. The usage is measured by the kernel, as in
/// `/usr/bin/time -v`. Throws std::system_error if the program cannot be started, and Interrupted
/// if `limits.interrupted` returned true.
ProcessUsage RunProgram(const std::vector<std::string>& command,
                        const std::filesystem::path& output_file, const ProcessLimits& limits);

}  // namespace dn::apps
