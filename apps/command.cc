#include "command.h"

#include <ceres/version.h>
#include <dn/builder/adjust.h>
#include <dn/error.h>
#include <fmt/format.h>
#include <unistd.h>

#include <Eigen/Core>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <thread>

namespace dn::apps {
namespace {

volatile std::sig_atomic_t g_interrupted = 0;

Json& CommandLine() {
  static Json arguments = Json::array();
  return arguments;
}

void OnSignal(int /*signal*/) { g_interrupted = 1; }

double Since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

struct Failure {
  int exit_code;
  std::string kind;
  std::string message;
};

std::string WithLocation(const InvalidInput& error) {
  const std::string where = error.where().ToString();
  const std::string what = error.what();
  return where.empty() || what.find(where) != std::string::npos ? what : what + " (" + where + ")";
}

Failure Classify(const std::exception& error) {
  if (dynamic_cast<const dn::Interrupted*>(&error) != nullptr || Interrupted()) {
    return {130, "interrupted", "interrupted; no result was written"};
  }
  if (const auto* config = dynamic_cast<const InvalidConfig*>(&error)) {
    return {2, "configuration", WithLocation(*config)};
  }
  if (const auto* input = dynamic_cast<const InvalidInput*>(&error)) {
    return {1, "input", WithLocation(*input)};
  }
  if (dynamic_cast<const RankDeficient*>(&error) != nullptr)
    return {1, "not_observable", error.what()};
  if (dynamic_cast<const NotConverged*>(&error) != nullptr)
    return {1, "not_converged", error.what()};
  if (dynamic_cast<const std::filesystem::filesystem_error*>(&error) != nullptr) {
    return {1, "output", error.what()};
  }
  if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr) {
    return {1, "memory",
            "out of memory; lower network.node_rate_hz or thin the pairs (lidar.pairs)"};
  }
  return {1, "internal", error.what()};
}

std::string OneLine(std::string text) {
  for (char& c : text) {
    if (c == '\n' || c == '\r') c = ' ';
  }
  return text;
}

/// What was printed may wait in a buffer that cannot be written, on a full disk say.
bool FlushStandardOutput(const std::string& command) {
  const bool written = std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
  if (!written) {
    fmt::print(stderr, "dn {}: error: the standard output cannot be written\n", command);
  }
  return written;
}

Json Versions() {
  return {{"dn", DN_VERSION},
          {"ceres", CERES_VERSION_STRING},
          {"eigen",
           fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
          {"compiler", __VERSION__}};
}

}  // namespace

void RememberCommandLine(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) CommandLine().push_back(argv[i]);
}

bool Interrupted() { return g_interrupted != 0; }

void InstallInterruptHandler() {
  std::signal(SIGINT, OnSignal);
  std::signal(SIGTERM, OnSignal);
}

Progress::Progress(std::string command)
    : command_(std::move(command)), terminal_(isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() { EndLine(); }

void Progress::EndLine() {
  if (line_open_) std::fputc('\n', stderr);
  line_open_ = false;
}

void Progress::Stage(const std::string& stage, const std::string& detail) {
  const bool entered = stage != stage_;
  stage_ = stage;
  const std::string text =
      "dn " + command_ + ": " + stage + (detail.empty() ? std::string() : " (" + detail + ")");
  if (terminal_) {
    if (entered) EndLine();
    fmt::print(stderr, "\r\033[K{}", text);
    std::fflush(stderr);
    line_open_ = true;
  } else if (entered) {
    fmt::print(stderr, "{}\n", text);
  }
}

void Progress::Warn(const std::string& message) {
  EndLine();
  fmt::print(stderr, "dn {}: warning: {}\n", command_, OneLine(message));
}

Run::Run(std::string command, const CommonOptions& options)
    : progress(command), command_(std::move(command)), options_(options) {
  report["schema"] = "dn.report/1";
  report["command"] = command_;
  report["arguments"] = CommandLine();
  report["versions"] = Versions();
  report["threads"] = options.threads;
  report["seed"] = nullptr;
  report["error"] = nullptr;
}

OutputDirectory& Run::files() {
  if (options_.out.empty()) throw InvalidConfig("no output directory: give --out DIR");
  if (!files_) files_ = std::make_unique<OutputDirectory>(options_.out);
  return *files_;
}

void Run::AddFile(const std::string& name, const std::string& content) {
  if (!options_.out.empty()) files().Add(name, content);
}

void Run::Commit() {
  report["timings_s"]["total"] = Since(start_);
  AddFile("report.json", FormatJson(report));
  if (files_) files_->Commit();
}

namespace {

// The body's exit code when its results are to be written: 1 when they must not pass for a success.
int RunBody(Run& run, const std::function<void(Run&)>& body) {
  try {
    body(run);
    return 0;
  } catch (const FailedWithResults& error) {
    run.report["error"] = {{"kind", error.kind()}, {"message", error.what()}};
    fmt::print(stderr, "dn {}: error: {}\n", run.command(), OneLine(error.what()));
    return 1;
  }
}

}  // namespace

int Execute(const std::string& command, const CommonOptions& options,
            const std::function<void(Run&)>& body) {
  Failure failure;
  {
    Run run(command, options);
    try {
      if (!options.out.empty()) run.files();  // fail before the work, not after it
      const int exit_code = RunBody(run, body);
      if (Interrupted()) throw dn::Interrupted();
      run.Commit();
      return FlushStandardOutput(command) ? exit_code : 1;
    } catch (const std::exception& error) {
      failure = Classify(error);
    }
  }
  fmt::print(stderr, "dn {}: error: {}\n", command, OneLine(failure.message));
  if (!options.out.empty()) {
    try {
      Run report(command, options);
      report.report["error"] = {{"kind", failure.kind}, {"message", failure.message}};
      report.Commit();
    } catch (const std::exception&) {
      // The directory cannot be written: the line on stderr has said what failed.
      return failure.exit_code;
    }
  }
  return failure.exit_code;
}

void AddCommonOptions(CLI::App* app, CommonOptions* options, bool out_required) {
  const int cores = static_cast<int>(std::thread::hardware_concurrency());
  options->threads = std::max(1, cores);
  app->set_version_flag("--version", "dn " DN_VERSION);
  app->add_option("--threads", options->threads, "Threads for evaluating the network")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  auto* out = app->add_option("--out", options->out, "Directory for the results, made if absent")
                  ->check([](const std::string& text) {
                    return text.empty() ? std::string("is empty") : std::string();
                  });
  if (out_required) out->required();
}

}  // namespace dn::apps
