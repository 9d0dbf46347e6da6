#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "command.h"

namespace dn::apps {

/// Returns the file with the messages of RunIntoFolder.
std::filesystem::path LogFile(const std::filesystem::path& out);

/// Runs a command of this program with --out in a process of its own, whose memory is free again
/// afterwards. `changes`: --set values. Its messages go to LogFile. Returns its exit code; throws
/// Interrupted after a signal to this process.
int RunIntoFolder(std::vector<std::string> words, const std::vector<std::string>& changes,
                  int threads, const std::filesystem::path& out);

/// Returns why RunIntoFolder failed: the message in its report, the signal that ended it, or the
/// place of its messages. `what`: the command as a noun.
std::string FailureText(int exit_code, const std::filesystem::path& out, const std::string& what);

/// Calls work(k, threads) for `count` flights, `at_once` of them at the same time, and shows the
/// progress under the name `stage`. The flights share the threads of the run.
void ForFlights(std::size_t count, int at_once, const std::string& stage, Run* run,
                const std::function<void(std::size_t k, int threads)>& work);

}  // namespace dn::apps
