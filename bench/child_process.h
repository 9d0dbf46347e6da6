#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace dn::bench {

/// What a finished program used.
struct ProcessUsage {
  int exit_code = -1;  ///< 128 + signal when it was killed
  double wall_s = 0.0;
  double cpu_s = 0.0;  ///< user and system, all threads
  double peak_rss_mib = 0.0;
};

/// Runs a program with its output in a file, and waits for it; after timeout_s it is killed. The
/// figures are those of the kernel, as in `/usr/bin/time -v`. Throws std::system_error when the
/// program cannot be started.
ProcessUsage RunProgram(const std::vector<std::string>& command,
                        const std::filesystem::path& output_file, unsigned timeout_s);

}  // namespace dn::bench
