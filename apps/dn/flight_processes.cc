#include "flight_processes.h"

#include <dn/interrupted.h>
#include <dn/parallel.h>
#include <dn/report/json_reader.h>
#include <fmt/format.h>

#include <algorithm>
#include <mutex>

#include "child_process.h"
#include "interruption.h"
#include "json_file.h"

namespace dn::apps {
namespace {

namespace fs = std::filesystem;

constexpr int kInterruptedCode = 130;

}  // namespace

fs::path LogFile(const fs::path& out) {
  fs::path log = out;
  log += ".log";
  return log;
}

int RunIntoFolder(std::vector<std::string> words, const std::vector<std::string>& changes,
                  int threads, const fs::path& out) {
  words.insert(words.begin(), kThisProgram);
  for (const std::string& change : changes) words.insert(words.end(), {"--set", change});
  words.insert(words.end(), {"--threads", std::to_string(threads), "--out", out.string()});
  ProcessLimits limits;
  limits.interrupted = [] { return SignalReceived(); };
  const ProcessUsage usage = RunProgram(words, LogFile(out), limits);
  if (usage.exit_code == kInterruptedCode) throw dn::Interrupted();
  return usage.exit_code;
}

std::string FailureText(int exit_code, const fs::path& out, const std::string& what) {
  if (exit_code > kFirstSignal) {
    return fmt::format("{} was ended by signal {}", what, exit_code - kFirstSignal);
  }
  try {
    const Json report = ReadJsonFile(out / "report.json");
    return JsonPlace(report, "").At("error").At("message").Text();
  } catch (const InvalidInput&) {
    return what + " failed; see " + LogFile(out).string();
  }
}

void ForFlights(std::size_t count, int at_once, const std::string& stage, Run* run,
                const std::function<void(std::size_t, int)>& work) {
  const auto flights = static_cast<int>(count);
  const int side_by_side = std::min(at_once, flights);
  const int threads = std::max(1, run->options().threads / side_by_side);
  std::mutex mutex;
  int done = 0;
  const auto tell = [&](int finished) {
    const std::lock_guard lock(mutex);
    done += finished;
    run->progress().Stage(stage, Share{static_cast<double>(done), static_cast<double>(count), ""});
  };
  ParallelFor(flights, side_by_side, [&](int k) {
    tell(0);
    work(static_cast<std::size_t>(k), threads);
    tell(1);
  });
}

}  // namespace dn::apps
