#include <fcntl.h>
#include <fmt/format.h>
#include <malloc.h>
#include <unistd.h>

#include <cerrno>
#include <new>
#include <sstream>

#include "command.h"
#include "standard_output.h"
#include "usage_error.h"

namespace {

// The next opened file would take the descriptor of a closed standard stream. Therefore closed
// streams are opened on /dev/null, so that stdin reads nothing, writing to stdout fails, and output
// to stderr is dropped.
void OpenStandardStreams() {
  for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(fd, F_GETFD) >= 0 || errno != EBADF) continue;
    ::open("/dev/null", fd == STDOUT_FILENO ? O_RDONLY : O_WRONLY);
  }
}

// Each adjustment step allocates and frees large matrices. Keeping freed memory in the process
// saves returning it to the system, which would clear it again.
void KeepFreedMemory() {
  ::mallopt(M_MMAP_THRESHOLD, 32 << 20);  // the largest value that glibc accepts
  ::mallopt(M_TRIM_THRESHOLD, 1 << 30);
  ::mallopt(M_TOP_PAD, 16 << 20);  // applies also to the arenas of short-lived threads
}

int ParseAndRun(int argc, char** argv) {
  CLI::App program{
      "dn fuses raw inertial, GNSS and lidar data of a flight in one adjustment: it estimates "
      "trajectory,\n"
      "time-correlated inertial errors and lidar boresight together, with their covariance.",
      "dn"};
  program.set_version_flag("--version", "dn " DN_VERSION);
  program.require_subcommand(1);
  program.footer("Example: dn simulate lar3 --out flight && dn calibrate flight --out result");
  dn::apps::Action action;
  dn::apps::AddInit(&program, &action);
  dn::apps::AddCheck(&program, &action);
  dn::apps::AddCalibrate(&program, &action);
  dn::apps::AddSmooth(&program, &action);
  dn::apps::AddSimulate(&program, &action);
  dn::apps::AddStudy(&program, &action);
  dn::apps::AddMatch(&program, &action);
  dn::apps::AddGeoref(&program, &action);
  dn::apps::AddGap(&program, &action);
  dn::apps::AddMonteCarlo(&program, &action);
  dn::apps::AddBlindCheck(&program, &action);
  dn::apps::AddMerge(&program, &action);
  dn::apps::AddAllan(&program, &action);
  dn::apps::AddReport(&program, &action);
  dn::apps::AddCompletion(&program, &action);
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() != 0) {
      dn::apps::Say(dn::apps::UsageError(program, error));
      return 2;
    }
    std::ostringstream help;
    program.exit(error, help, help);
    fmt::print("{}", help.str());
    return dn::apps::FlushStandardOutput("help") ? 0 : 1;
  }
  dn::apps::RememberCommandLine(argc, argv);
  return action();
}

}  // namespace

int main(int argc, char** argv) {
  OpenStandardStreams();
  KeepFreedMemory();
  dn::apps::InstallSignalHandlers();
  dn::apps::GuardStandardOutput();
  try {
    return ParseAndRun(argc, argv);
  } catch (const std::bad_alloc&) {
    dn::apps::Say("dn: error: out of memory at program start; allow the process more memory");
    return 1;
  } catch (const std::exception& error) {
    dn::apps::Say(std::string("dn: error: ") + error.what());
    return 1;
  }
}
