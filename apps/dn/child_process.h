#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace dn::apps {

/// What a finished program used.
struct ProcessUsage {
  int exit_code = -1;  ///< 128 + signal when it was killed
  double wall_s = 0.0;
  double cpu_s = 0.0;  ///< user and system, all threads
  double peak_rss_mib = 0.0;
};

/// When a program is ended before its time.
struct ProcessLimits {
  double longest_s = 1e9;                       ///< then it is ended
  std::function<bool()> interrupted = nullptr;  ///< polled; true ends it
};

/// Runs a program with its output in a file, and waits for it. It is ended by SIGTERM, so that it can
/// remove what it staged, and two seconds later by SIGKILL; by SIGTERM also when the calling thread
/// dies. The figures are those of the kernel, as in `/usr/bin/time -v`. Throws
/// std::system_error when the program cannot be started, Interrupted when it was interrupted.
ProcessUsage RunProgram(const std::vector<std::string>& command,
                        const std::filesystem::path& output_file, const ProcessLimits& limits);

}  // namespace dn::apps
