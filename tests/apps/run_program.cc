#include "run_program.h"

#include <fcntl.h>
#include <grp.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>

namespace dn::testing {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
constexpr std::chrono::seconds kLongestRun{120};

struct Pipe {
  Pipe() {
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("pipe2 failed");
  }
  std::array<int, 2> ends{};
};

template <class Resource>
void Limit(Resource resource, std::optional<long> most) {
  if (!most) return;
  const auto limit = static_cast<rlim_t>(*most);
  const rlimit bound{limit, limit};
  ::setrlimit(resource, &bound);
}

void BecomeNobody() {
  constexpr uid_t kNobody = 65534;
  const bool became =
      ::setgroups(0, nullptr) == 0 && ::setgid(kNobody) == 0 && ::setuid(kNobody) == 0;
  if (!became) ::_exit(127);
}

[[noreturn]] void BecomeProgram(const ProgramOptions& options, const Pipe& out, const Pipe& err) {
  const int out_file = options.out_file ? ::open(options.out_file->c_str(), O_WRONLY) : -1;
  ::dup2(options.out_file ? out_file : out.ends[1], STDOUT_FILENO);
  const int err_file = options.err_file ? ::open(options.err_file->c_str(), O_WRONLY) : -1;
  ::dup2(options.err_file ? err_file : err.ends[1], STDERR_FILENO);
  Limit(RLIMIT_FSIZE, options.max_file_bytes);
  if (kMemoryCanBeLimited) Limit(RLIMIT_AS, options.max_memory_bytes);
  Limit(RLIMIT_NPROC, options.max_threads);
  // Leak detection starts a thread of its own.
  if (options.max_threads) ::setenv("ASAN_OPTIONS", "detect_leaks=0", 1);
  if (options.max_threads && ::geteuid() == 0) BecomeNobody();
  for (const int stream : options.closed_streams) ::close(stream);
  std::vector<std::string> words{DN_PROGRAM};
  words.insert(words.end(), options.arguments.begin(), options.arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  ::execv(DN_PROGRAM, argv.data());
  ::_exit(127);
}

/// Appends the readable bytes to the text. Returns false at the end of the stream.
bool Append(int fd, std::string* text) {
  std::array<char, 4096> buffer;
  const ssize_t count = ::read(fd, buffer.data(), buffer.size());
  if (count > 0) text->append(buffer.data(), static_cast<std::size_t>(count));
  return count > 0;
}

/// Reads stdout and stderr until both are closed, and sends the signal when its condition is met.
void Follow(pid_t child, const ProgramOptions& options, const Pipe& out, const Pipe& err,
            ProgramRun* run) {
  std::array<pollfd, 2> streams{pollfd{out.ends[0], POLLIN, 0}, pollfd{err.ends[0], POLLIN, 0}};
  const std::array<std::string*, 2> texts{&run->out, &run->err};
  const auto deadline = Clock::now() + kLongestRun;
  bool signalled = options.signal == 0 && !options.at_signal;
  Clock::time_point signal_time = Clock::now();
  while (streams[0].fd >= 0 || streams[1].fd >= 0) {
    ::poll(streams.data(), streams.size(), 1000);
    for (std::size_t i = 0; i < streams.size(); ++i) {
      const bool ready = streams[i].fd >= 0 && streams[i].revents != 0;
      if (ready && !Append(streams[i].fd, texts[i])) streams[i].fd = -1;
    }
    if (!signalled && run->err.find(options.signal_after) != std::string::npos) {
      signal_time = Clock::now();
      if (options.at_signal) options.at_signal(child);
      for (int i = 0; i < options.signal_count; ++i) ::kill(child, options.signal);
      signalled = true;
    }
    if (Clock::now() > deadline) ::kill(child, SIGKILL);
  }
  run->end_after_signal_s = std::chrono::duration<double>(Clock::now() - signal_time).count();
}

}  // namespace

ProgramRun RunProgram(const ProgramOptions& options) {
  const Pipe out;
  const Pipe err;
  const pid_t child = ::fork();
  if (child < 0) throw std::runtime_error("fork failed");
  if (child == 0) BecomeProgram(options, out, err);
  ::close(out.ends[1]);
  ::close(err.ends[1]);
  ProgramRun run;
  Follow(child, options, out, err, &run);
  ::close(out.ends[0]);
  ::close(err.ends[0]);
  int status = 0;
  ::waitpid(child, &status, 0);
  if (WIFEXITED(status)) run.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) run.signal = WTERMSIG(status);
  return run;
}

ProgramRun RunProgram(const std::vector<std::string>& arguments) {
  ProgramOptions options;
  options.arguments = arguments;
  return RunProgram(options);
}

fs::path ShortFlight() { return fs::path(DN_CLI_WORK) / "flight"; }
fs::path CheckResult() { return fs::path(DN_CLI_WORK) / "check"; }
fs::path SmoothResult() { return fs::path(DN_CLI_WORK) / "smooth"; }
fs::path CalibrateResult() { return fs::path(DN_CLI_WORK) / "calibrate"; }
fs::path GapResult() { return fs::path(DN_CLI_WORK) / "gap"; }
fs::path ShortScenario() { return DN_SHORT_SCENARIO; }

std::string FileContent(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw std::runtime_error("cannot read " + file.string());
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::string WithoutLines(const std::string& text, const std::string& part) {
  std::istringstream in(text);
  std::string kept;
  for (std::string line; std::getline(in, line);) {
    if (line.find(part) == std::string::npos) kept += line + "\n";
  }
  return kept;
}

std::vector<std::string> NamesIn(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) {
    names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace dn::testing
