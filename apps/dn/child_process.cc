#include "child_process.h"

#include <dn/interrupted.h>
#include <dn/stopwatch.h>
#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <optional>
#include <system_error>
#include <thread>

namespace dn::apps {
namespace {

constexpr std::chrono::milliseconds kPoll{5};
constexpr double kGrace_s = 2.0;
constexpr int kCannotRun = 127;

double Seconds(const timeval& t) {
  return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
}

// Runs between fork and exec and may therefore only make system calls.
[[noreturn]] void Become(std::vector<char*>& arguments, const char* output_file, pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (::getppid() != parent) _exit(kCannotRun);  // the parent died before prctl
  const int file = ::open(output_file, O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (file >= 0) {
    ::dup2(file, STDOUT_FILENO);
    ::dup2(file, STDERR_FILENO);
  }
  ::execvp(arguments.front(), arguments.data());
  _exit(kCannotRun);
}

pid_t Start(const std::vector<std::string>& command, const std::string& output_file) {
  std::vector<std::string> words = command;
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child < 0) throw std::system_error(errno, std::generic_category(), "fork");
  if (child == 0) Become(arguments, output_file.c_str(), parent);
  return child;
}

}  // namespace

ProcessUsage RunProgram(const std::vector<std::string>& command,
                        const std::filesystem::path& output_file, const ProcessLimits& limits) {
  const Stopwatch watch;
  const pid_t child = Start(command, output_file.string());
  bool interrupted = false;
  std::optional<double> asked_at_s;
  int status = 0;
  rusage usage{};
  for (;;) {
    const pid_t ended = ::wait4(child, &status, WNOHANG, &usage);
    if (ended == child) break;
    if (ended < 0 && errno != EINTR) {
      throw std::system_error(errno, std::generic_category(), "wait4");
    }
    interrupted = interrupted || (limits.interrupted && limits.interrupted());
    const double now_s = watch.seconds();
    if (!asked_at_s && (interrupted || now_s > limits.longest_s)) {
      ::kill(child, SIGTERM);
      asked_at_s = now_s;
    }
    if (asked_at_s && now_s > *asked_at_s + kGrace_s) ::kill(child, SIGKILL);
    std::this_thread::sleep_for(kPoll);
  }
  const double wall_s = watch.seconds();
  if (interrupted) throw dn::Interrupted();
  if (WIFEXITED(status) && WEXITSTATUS(status) == kCannotRun) {
    throw std::system_error(ENOENT, std::generic_category(), "cannot run " + command.front());
  }
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), wall_s,
          Seconds(usage.ru_utime) + Seconds(usage.ru_stime),
          static_cast<double>(usage.ru_maxrss) / 1024.0};
}

}  // namespace dn::apps
