#include "command.h"

#include <ceres/version.h>
#include <dn/adjustment/adjust.h>
#include <dn/error.h>
#include <dn/page/page.h>
#include <fmt/format.h>

#include <Eigen/Core>
#include <chrono>
#include <cstdio>
#include <future>
#include <string_view>
#include <system_error>
#include <thread>

#include "input_files.h"
#include "memory_advice.h"
#include "option_checks.h"
#include "shown_text.h"

namespace dn::apps {
namespace {

constexpr const char* kReportName = "report.json";
constexpr const char* kPageName = "report.html";

std::string InterruptedText(const CommonOptions& options) {
  std::string text = "interrupted; no result was written";
  if (options.resumable) {
    text += "; finished work is kept, run the same command again to continue";
  }
  return text;
}

Json& CommandLine() {
  static Json arguments = Json::array();
  return arguments;
}

struct Failure {
  int exit_code;
  std::string kind;
  std::string message;
};

// Returns whether the message names the path `where`. The path must contain a slash, because a
// plain word of the message could equal it.
bool Names(const std::string& message, const std::string& where) {
  return where.find('/') != std::string::npos && message.find(where) != std::string::npos;
}

std::string OutputText(const std::filesystem::filesystem_error& error) {
  const std::string_view what = error.what();
  const std::size_t cannot = what.find("cannot ");
  if (cannot != std::string_view::npos) return std::string(what.substr(cannot));
  return fmt::format("{}: {}", error.path1().string(), error.code().message());
}

Failure Classify(const std::exception& error, const std::string& command,
                 const CommonOptions& options) {
  if (dynamic_cast<const dn::Interrupted*>(&error) != nullptr || SignalReceived()) {
    return {130, "interrupted", InterruptedText(options)};
  }
  if (const auto* config = dynamic_cast<const InvalidConfig*>(&error)) {
    return {2, "configuration", FormatWithLocation(*config)};
  }
  if (const auto* input = dynamic_cast<const InvalidInput*>(&error)) {
    return {1, "input", FormatWithLocation(*input)};
  }
  if (dynamic_cast<const RankDeficient*>(&error) != nullptr)
    return {1, "not_observable", error.what()};
  if (dynamic_cast<const NotConverged*>(&error) != nullptr)
    return {1, "not_converged", error.what()};
  if (const auto* file = dynamic_cast<const std::filesystem::filesystem_error*>(&error)) {
    return {1, "output", OutputText(*file)};
  }
  if (dynamic_cast<const UnusableOutput*>(&error) != nullptr) return {1, "output", error.what()};
  if (const auto* system = dynamic_cast<const std::system_error*>(&error);
      system != nullptr && system->code() == std::errc::resource_unavailable_try_again) {
    return {1, "threads", "no more threads can be started; give a smaller --threads"};
  }
  if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr ||
      dynamic_cast<const std::length_error*>(&error) != nullptr) {
    return {1, "memory", "out of memory; " + MemoryAdvice(command)};
  }
  return {1, "internal", error.what()};
}

Json Versions() {
  return {{"dn", DN_VERSION},
          {"ceres", CERES_VERSION_STRING},
          {"eigen",
           fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
          {"compiler", __VERSION__}};
}

}  // namespace

bool FlushStandardOutput(const std::string& command) {
  const bool written = std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
  if (!written) {
    Say("dn " + command + ": error: the standard output cannot be written");
  }
  return written;
}

std::string FormatWithLocation(const InvalidInput& error) {
  const std::string where = error.where().ToString();
  const std::string what = error.what();
  return where.empty() || Names(what, where) ? what : what + " (" + where + ")";
}

void RememberCommandLine(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) CommandLine().push_back(argv[i]);
}

namespace {

void WriteLine(const std::string& line) {
  const std::string text = line + "\n";
  std::fwrite(text.data(), 1, text.size(), stderr);  // a failure cannot be reported anywhere
}

}  // namespace

void Say(const std::string& line) { WriteLine(Printable(line)); }

void SayJson(const Json& line) {
  constexpr bool kAsciiOnly = true;
  WriteLine(line.dump(-1, ' ', kAsciiOnly, Json::error_handler_t::replace));
}

namespace {

/// Returns how many of the wanted threads can be started now, at least 1.
int StartableThreads(int wanted) {
  std::promise<void> enough;
  const std::shared_future<void> wait = enough.get_future().share();
  std::vector<std::thread> threads;
  threads.reserve(static_cast<std::size_t>(wanted));
  try {
    for (int i = 0; i < wanted; ++i) threads.emplace_back([wait] { wait.wait(); });
  } catch (const std::exception&) {
    wanted = std::max(1, static_cast<int>(threads.size()));
  }
  enough.set_value();
  for (std::thread& thread : threads) thread.join();
  return wanted;
}

}  // namespace

Run::Run(std::string command, const CommonOptions& options)
    : command_(std::move(command)), options_(options), progress_(command_, options.json_progress) {
  if (options_.threads > 1) options_.threads = StartableThreads(options_.threads);
  report_ = EmptyReport();
  if (options_.threads == options.threads) return;
  progress_.Warn(
      fmt::format("only {} of {} threads can be started", options_.threads, options.threads));
}

Json Run::EmptyReport() const {
  return {{"schema", "dn.report/1"}, {"command", command_},         {"arguments", CommandLine()},
          {"versions", Versions()},  {"threads", options_.threads}, {"seed", nullptr},
          {"error", nullptr},        {"files", Json::array()}};
}

Json Run::FailureReport(Json failed, const std::string& kind, const std::string& message) const {
  failed["error"] = {{"kind", kind}, {"message", message}};
  failed["files"] = {kReportName};
  failed["timings_s"]["total"] = watch_.seconds();
  return failed;
}

OutputDirectory& Run::files() {
  if (options_.out.empty()) throw InvalidConfig("no output directory: give --out DIR");
  if (!files_) throw std::logic_error("the output directory was not taken");
  return *files_;
}

void Run::TakeOutput() {
  if (options_.out.empty()) return;
  ExpectHarmless(options_.out, options_.inputs, options_.writes_flight);
  files_ = std::make_unique<OutputDirectory>(options_.out);
  files_->Protect(options_.inputs.All());
  const std::string interrupted = InterruptedText(options_);
  PrepareForcedEnd(command_, interrupted, options_.out, files_->staging(),
                   FormatJson(FailureReport(EmptyReport(), "interrupted", interrupted)));
  files_->Remove(EarlierResults(options_.out));
}

void Run::AddFile(const std::string& name, const std::string& content) {
  if (!options_.out.empty()) files().Add(name, content);
}

// The page is made from the staged files, as dn report makes it from published ones. If the page
// fails, the result is published without it.
void Run::AddPage() {
  try {
    files_->Add(kPageName, ToHtml(MakePage(files_->staging())));
  } catch (const InvalidInput& error) {
    progress_.Warn(std::string("no report.html: ") + error.what());
  }
}

void Run::ReadsStrips() {
  options_.inputs.files = options_.inputs.All();
  options_.inputs.strips.clear();
}

void Run::Publish() {
  if (files_ && !report_.contains("inputs")) report_["inputs"] = InputFilesJson(options_.inputs);
  if (!BeginPublishing()) throw dn::Interrupted();
  report_["timings_s"]["total"] = watch_.seconds();
  if (!files_) return;
  report_["files"] = files_->staged();
  report_["files"].insert(report_["files"].end(), {kReportName, kPageName});
  files_->Add(kReportName, FormatJson(report_));
  AddPage();
  files_->Commit();
}

void Run::PublishFailure(const std::string& kind, const std::string& message) {
  BeginReporting();
  if (!files_) return;
  files_->Discard();
  report_ = FailureReport(std::move(report_), kind, message);
  const bool of_data = kind == "input" || kind == "not_observable" || kind == "not_converged";
  const bool has_page = of_data && report_.contains("counts");  // the data were read
  if (has_page) {
    report_["tried"] = progress_.stages();
    report_["files"].push_back(kPageName);
  }
  files_->Add(kReportName, FormatJson(report_));
  if (has_page) AddPage();
  files_->Commit();
}

namespace {

// Returns 0, or 1 if the body threw FailedWithResults. In both cases the results are published.
int RunBody(Run& run, const std::function<void(Run&)>& body) {
  try {
    body(run);
    return 0;
  } catch (const FailedWithResults& error) {
    run.report()["error"] = {{"kind", error.kind()}, {"message", error.what()}};
    Say("dn " + run.command() + ": error: " + error.what());
    return 1;
  }
}

int EndFailed(Run& run, const Failure& failure) {
  try {
    run.PublishFailure(failure.kind, failure.message);
  } catch (const std::exception&) {
    // The directory cannot be written. The line on stderr still reports the first error.
  }
  Say("dn " + run.command() + ": error: " + failure.message);
  return failure.exit_code;
}

}  // namespace

int Execute(const std::string& command, const CommonOptions& options,
            const std::function<void(Run&)>& body) {
  PrepareForcedEnd(command, InterruptedText(options), {}, {}, {});
  Run run(command, options);
  Failure failure;
  try {
    run.TakeOutput();  // fails before the work instead of after it
    for (const std::filesystem::path& link : options.inputs.circular_links) {
      run.progress().Warn("the link " + link.string() + " leads back to itself; it is ignored");
    }
    const int exit_code = RunBody(run, body);
    run.Publish();
    return FlushStandardOutput(command) ? exit_code : 1;
  } catch (const std::exception& error) {
    failure = Classify(error, command, options);
  }
  return EndFailed(run, failure);
}

CLI::Option* AddChanges(CLI::App* app, const std::string& of, const std::string& example,
                        CommonOptions* options) {
  return app
      ->add_option("--set", options->changes,
                   "key=value: replaces a value of " + of + " for this run, e.g. " + example +
                       "; repeatable")
      ->take_all()
      ->expected(1);
}

void AddFlightOptions(CLI::App* app, std::string* flight, CommonOptions* options) {
  app->add_option("FLIGHT", *flight, "Flight folder or YAML file of a flight")->required();
  AddChanges(app, "flight.yaml", "gnss.sigma_scale=2", options);
  AddScanner(app, options);
}

void AddScanner(CLI::App* app, CommonOptions* options) {
  app->add_option_function<std::string>(
         "--scanner",
         [options](const std::string& name) { options->changes.push_back("scanner=" + name); },
         "Name of the scanner to use, if flight.yaml lists several under lidar")
      ->expected(1);
}

void AddUnmodelled(CLI::App* app, CommonOptions* options) {
  app->add_option_function<std::string>(
         "--unmodelled",
         [options](const std::string& value) { options->changes.push_back("unmodelled=" + value); },
         "Sizes of the effects that the model leaves out, as in flight.yaml; none: the pure model")
      ->expected(1);
}

void AddThreads(CLI::App* app, CommonOptions* options) {
  const int cores = static_cast<int>(std::thread::hardware_concurrency());
  options->threads = std::max(1, cores);
  app->set_version_flag("--version", "dn " DN_VERSION);
  app->add_option("--threads", options->threads,
                  "Number of threads; results for different numbers agree within 1e-9 sigma")
      ->check(WholeNumber(1, 1024))
      ->capture_default_str();
  app->add_flag("--json-progress", options->json_progress,
                "Prints progress and remaining time on stderr as JSON lines");
}

void AddCommonOptions(CLI::App* app, CommonOptions* options, bool out_required) {
  AddThreads(app, options);
  auto* out = app->add_option("--out", options->out, "Result directory, created if absent")
                  ->check([](const std::string& text) {
                    return text.empty() ? std::string("is empty") : std::string();
                  });
  if (out_required) out->required();
}

}  // namespace dn::apps
