#include "gnuplot_process.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <string_view>
#include <thread>

namespace dn::report_internal {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::seconds kLongestRun{20};
constexpr std::chrono::milliseconds kPoll{5};

static_assert(std::atomic<int>::is_always_lock_free);
constexpr int kNone = 0, kStarting = -1;
std::atomic<int> g_child{kNone};
std::atomic<bool> g_forbidden{false};

/// An unnamed file in memory.
class MemoryFile {
 public:
  explicit MemoryFile(const char* name) : fd_(::memfd_create(name, MFD_CLOEXEC)) {}
  ~MemoryFile() {
    if (fd_ >= 0) ::close(fd_);
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  int fd() const { return fd_; }

  /// Writes the text and moves the position to the start; returns false if it could not write all
  /// of it.
  bool Fill(std::string_view text) const {
    while (!text.empty()) {
      const ssize_t written = ::write(fd_, text.data(), text.size());
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) return false;
      text.remove_prefix(static_cast<std::size_t>(written));
    }
    return ::lseek(fd_, 0, SEEK_SET) == 0;
  }

  std::string Content() const {
    std::string text;
    std::array<char, 65536> buffer;
    ::lseek(fd_, 0, SEEK_SET);
    for (ssize_t n = 0; (n = ::read(fd_, buffer.data(), buffer.size())) != 0;) {
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) return {};
      text.append(buffer.data(), static_cast<std::size_t>(n));
    }
    return text;
  }

 private:
  int fd_;
};

/// Streams and signals of the child: default handlers and no blocked signals, so that signals end
/// it.
class SpawnSettings {
 public:
  SpawnSettings(int in, int out) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_adddup2(&actions_, in, STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions_, out, STDOUT_FILENO);
    posix_spawn_file_actions_addopen(&actions_, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawnattr_init(&attributes_);
    sigset_t none;
    sigemptyset(&none);
    sigset_t all;
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setsigdefault(&attributes_, &all);
    posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  }
  ~SpawnSettings() {
    posix_spawn_file_actions_destroy(&actions_);
    posix_spawnattr_destroy(&attributes_);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;

  const posix_spawn_file_actions_t* actions() const { return &actions_; }
  const posix_spawnattr_t* attributes() const { return &attributes_; }

 private:
  posix_spawn_file_actions_t actions_{};
  posix_spawnattr_t attributes_{};
};

/// Name of the standard input: gnuplot reads a named file in blocks, but an unnamed stream byte by
/// byte.
constexpr const char* kInputByName = "/proc/self/fd/0";

/// Starts gnuplot; returns its process ID, or -1.
pid_t Start(const MemoryFile& script, const MemoryFile& svg) {
  const SpawnSettings settings(script.fd(), svg.fd());
  const char* search = std::getenv("PATH");
  std::string path = std::string("PATH=") + (search == nullptr ? "/usr/bin:/bin" : search);
  std::string locale = "LC_ALL=C.UTF-8", program = "gnuplot", without_start_up_files = "-d";
  std::string input = kInputByName;
  const bool has_name = ::access("/proc/self/fd", X_OK) == 0;
  const std::array<char*, 4> argv{program.data(), without_start_up_files.data(),
                                  has_name ? input.data() : nullptr, nullptr};
  const std::array<char*, 3> environment{path.data(), locale.data(), nullptr};
  pid_t child = -1;
  const int error = ::posix_spawnp(&child, program.c_str(), settings.actions(),
                                   settings.attributes(), argv.data(), environment.data());
  return error == 0 ? child : -1;
}

/// Starts gnuplot so that a signal handler on any thread always knows of it. The handler finds the
/// process in g_child, waits there for it, or prevents the start.
pid_t StartTracked(const MemoryFile& script, const MemoryFile& svg) {
  sigset_t all, before;
  sigfillset(&all);
  ::pthread_sigmask(SIG_SETMASK, &all, &before);
  g_child = kStarting;
  const pid_t child = g_forbidden ? -1 : Start(script, svg);
  g_child = child > 0 ? child : kNone;
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
  return child;
}

/// Waits for the process and returns whether it succeeded. Kills it after kLongestRun or an
/// interrupt.
bool WaitForSuccess(pid_t child, const std::function<bool()>& interrupted) {
  const auto deadline = Clock::now() + kLongestRun;
  for (;;) {
    int status = 0;
    const pid_t ended = ::waitpid(child, &status, WNOHANG);
    if (ended == child) return WIFEXITED(status) && WEXITSTATUS(status) == 0;
    if (ended < 0 && errno != EINTR) return false;
    if (Clock::now() > deadline || (interrupted && interrupted())) break;
    std::this_thread::sleep_for(kPoll);
  }
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  return false;
}

}  // namespace

std::optional<std::string> RunGnuplot(const std::string& script,
                                      const std::function<bool()>& interrupted) {
  const MemoryFile in("script"), out("svg");
  if (in.fd() < 0 || out.fd() < 0 || !in.Fill(script)) return std::nullopt;
  const pid_t child = StartTracked(in, out);
  if (child < 0) return std::nullopt;
  const bool succeeded = WaitForSuccess(child, interrupted);
  g_child = kNone;
  if (!succeeded) return std::nullopt;
  return out.Content();
}

void ForbidGnuplot() noexcept {
  g_forbidden = true;
  while (g_child == kStarting) ::poll(nullptr, 0, 1);
  if (const int child = g_child; child > 0) ::kill(child, SIGKILL);
}

}  // namespace dn::report_internal
