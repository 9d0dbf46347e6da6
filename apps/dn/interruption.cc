#include "interruption.h"

#include <dirent.h>
#include <dn/report/plot.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/time.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <string_view>

namespace dn::apps {
namespace {

constexpr suseconds_t kGraceMicroseconds = 400000;
constexpr int kInterruptedExitCode = 130;

static_assert(std::atomic<bool>::is_always_lock_free);
static_assert(std::atomic<const void*>::is_always_lock_free);
std::atomic<bool> g_interrupted{false};

/// A forced end and the publication of results exclude each other; the first to start wins.
enum class Course { kWork, kPublication, kForcedEnd };
static_assert(std::atomic<Course>::is_always_lock_free);
std::atomic<Course> g_course{Course::kWork};

/// Starts a course. Returns false if another one has been started before.
bool Take(Course course) {
  Course before = Course::kWork;
  return g_course.compare_exchange_strong(before, course);
}

[[noreturn]] void WaitForEnd() {
  for (;;) ::pause();
}

/// Data of the forced end, at a fixed address because a signal handler reads them.
struct ForcedEnd {
  std::string directory;
  std::string staging;  // name of the staging directory within `directory`
  std::string report;
  std::string message;
};
std::atomic<const ForcedEnd*> g_forced_end{nullptr};

// All functions from here to EndByForce run in a signal handler and must only make system calls.

void WriteAll(int fd, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(fd, text.data(), text.size());
    if (written <= 0) return;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

void RemoveContent(int directory, int depth);

bool RemoveEntry(int directory, const char* name, int depth) {
  if (::unlinkat(directory, name, 0) == 0) return true;
  if (errno != EISDIR || depth == 0) return false;
  const int below = ::openat(directory, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (below < 0) return false;
  RemoveContent(below, depth - 1);
  ::close(below);
  return ::unlinkat(directory, name, AT_REMOVEDIR) == 0;
}

/// Removes some entries. Returns true if it removed any: there may be more.
bool RemoveSome(int directory, int depth) {
  alignas(dirent64) std::array<char, 4096> buffer;
  bool removed = false;
  ::lseek(directory, 0, SEEK_SET);
  const ssize_t bytes = ::getdents64(directory, buffer.data(), buffer.size());
  for (ssize_t at = 0; at < bytes;) {
    dirent64 entry{};
    const auto header = static_cast<std::ptrdiff_t>(offsetof(dirent64, d_name));
    std::memcpy(&entry, buffer.data() + at, static_cast<std::size_t>(header));
    const char* name = buffer.data() + at + header;
    const bool itself = std::strcmp(name, ".") == 0 || std::strcmp(name, "..") == 0;
    if (!itself && RemoveEntry(directory, name, depth)) removed = true;
    at += entry.d_reclen;
  }
  return removed;
}

void RemoveContent(int directory, int depth) {
  while (RemoveSome(directory, depth)) {
  }
}

constexpr int kStagedLevels = 3;  // ".replaced/lidar/1_2.txt"
constexpr int kAttempts = 1000;

/// Removes the staging directory. Retries, because another thread may still stage files in it.
void RemoveStaging(int directory, const char* name, int staging) {
  for (int i = 0; i < kAttempts; ++i) {
    RemoveContent(staging, kStagedLevels);
    if (::unlinkat(directory, name, AT_REMOVEDIR) == 0 || errno != ENOTEMPTY) return;
  }
}

void LeaveReportOnly(const ForcedEnd& end) {
  const int directory = ::open(end.directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (directory < 0) return;
  const int staging =
      ::openat(directory, end.staging.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (staging < 0) return;
  RemoveContent(staging, kStagedLevels);
  const int report =
      ::openat(staging, "report.json", O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
  if (report >= 0) {
    WriteAll(report, end.report);
    ::fsync(report);
    ::renameat(staging, "report.json", directory, "report.json");
  }
  RemoveStaging(directory, end.staging.c_str(), staging);
}

/// Writes the message to stderr unless that would block, e.g. on a full pipe.
void SayWithoutWaiting(std::string_view message) {
  pollfd stream{STDERR_FILENO, POLLOUT, 0};
  if (::poll(&stream, 1, 0) == 1 && (stream.revents & POLLOUT) != 0) {
    WriteAll(STDERR_FILENO, message);
  }
}

void EndByForce() {
  if (!Take(Course::kForcedEnd)) {
    if (g_course == Course::kPublication) return;
    WaitForEnd();
  }
  EndDrawing();
  if (const ForcedEnd* end = g_forced_end.load()) {
    if (!end->staging.empty()) LeaveReportOnly(*end);
    SayWithoutWaiting(end->message);
  }
  ::_exit(kInterruptedExitCode);
}

void OnSignal(int /*signal*/) {
  const int before = errno;
  if (g_course != Course::kPublication) {
    if (g_interrupted.exchange(true)) EndByForce();
    const itimerval grace{{0, 0}, {0, kGraceMicroseconds}};
    ::setitimer(ITIMER_REAL, &grace, nullptr);
  }
  errno = before;
}

void OnAlarm(int /*signal*/) {
  if (g_interrupted) EndByForce();
}

void Handle(int signal, void (*handler)(int), int flags) {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = flags;
  sigfillset(&action.sa_mask);  // one handler at a time
  ::sigaction(signal, &action, nullptr);
}

bool IsIgnored(int signal) {
  struct sigaction action {};
  return ::sigaction(signal, nullptr, &action) == 0 && action.sa_handler == SIG_IGN;
}

}  // namespace

bool SignalReceived() { return g_interrupted; }

void InstallSignalHandlers() {
  for (const int signal : {SIGPIPE, SIGXFSZ}) Handle(signal, SIG_IGN, 0);
  Handle(SIGCHLD, SIG_DFL, 0);
  Handle(SIGALRM, OnAlarm, SA_RESTART);
  Handle(SIGINT, OnSignal, SA_RESTART);
  Handle(SIGTERM, OnSignal, SA_RESTART);
  if (!IsIgnored(SIGHUP)) Handle(SIGHUP, OnSignal, SA_RESTART);
  sigset_t ours;
  sigemptyset(&ours);
  for (const int signal : {SIGALRM, SIGINT, SIGTERM, SIGHUP}) sigaddset(&ours, signal);
  ::sigprocmask(SIG_UNBLOCK, &ours, nullptr);
}

void PrepareForcedEnd(const std::string& command, const std::string& message,
                      const std::filesystem::path& directory, const std::filesystem::path& staging,
                      const std::string& report) {
  static ForcedEnd end;
  g_forced_end = nullptr;
  end = {directory.string(), staging.filename().string(), report,
         "dn " + command + ": error: " + message + "\n"};
  g_forced_end = &end;
}

bool BeginPublishing() {
  BeginReporting();
  if (!g_interrupted) return true;
  g_course = Course::kWork;
  return false;
}

void BeginReporting() {
  if (!Take(Course::kPublication) && g_course == Course::kForcedEnd) WaitForEnd();
}

}  // namespace dn::apps
