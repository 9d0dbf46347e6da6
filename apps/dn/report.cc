#include <dn/error.h>
#include <dn/flight/atomic_file.h>
#include <dn/page/page.h>
#include <fmt/format.h>

#include "command.h"
#include "shown_text.h"

namespace dn::apps {
namespace {

struct ReportArguments {
  CommonOptions common;
  std::vector<std::string> folders;
  std::string file;
};

/// A page may take the place of a page, of nothing else.
CLI::Validator HtmlFile() {
  const auto check = [](const std::string& text) {
    const std::string extension = std::filesystem::path(text).extension().string();
    if (extension == ".html" || extension == ".htm") return std::string();
    return Quoted(text) + " does not end in .html: give the file of the page";
  };
  return {check, "FILE.html"};
}

void Report(const ReportArguments& options, Run& run) {
  run.progress.Stage("reading results");
  Document document = PageOf({options.folders.begin(), options.folders.end()});
  if (std::filesystem::is_directory(options.file)) {
    throw InvalidConfig("--out " + options.file + " is a folder; give the file of the page");
  }
  WriteFileAtomically(options.file, ToHtml(document));
  if (options.folders.size() == 1) document.sections.clear();  // the page has them
  fmt::print("{}", ToText(document));
}

}  // namespace

void AddReport(CLI::App* program, Action* action) {
  auto options = std::make_shared<ReportArguments>();
  CLI::App* app = program->add_subcommand(
      "report",
      "One offline page from result folders; several side by side, with their differences");
  app->add_option("DIR", options->folders, "Folders that commands have written with --out")
      ->required();
  app->add_option("--out", options->file, "The page, one file that needs no network")
      ->required()
      ->check(HtmlFile());
  AddThreads(app, &options->common);
  app->footer("Example: dn report result_may result_june --out both.html");
  app->callback([options, action] {
    *action = [options] {
      return Execute("report", options->common, [&](Run& run) { Report(*options, run); });
    };
  });
}

}  // namespace dn::apps
