#include <dn/error.h>
#include <dn/files/atomic_file.h>
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

/// Accepts only .html and .htm, so that the page cannot overwrite a file of another type.
CLI::Validator HtmlFile() {
  const auto check = [](const std::string& text) {
    const std::string extension = std::filesystem::path(text).extension().string();
    if (extension == ".html" || extension == ".htm") return std::string();
    return Quoted(text) + " does not end in .html: give the file name of the page";
  };
  return {check, "FILE.html"};
}

void Report(const ReportArguments& options, Run& run) {
  run.progress().Stage("reading results");
  Document document = MakePage({options.folders.begin(), options.folders.end()});
  if (std::filesystem::is_directory(options.file)) {
    throw InvalidConfig("--out " + options.file + " is a folder; give the file name of the page");
  }
  WriteFileAtomically(options.file, ToHtml(document));
  if (options.folders.size() == 1) document.sections.clear();  // only the page shows them
  fmt::print("{}", ToText(document));
}

}  // namespace

void AddReport(CLI::App* program, Action* action) {
  auto options = std::make_shared<ReportArguments>();
  CLI::App* app = program->add_subcommand(
      "report", "Makes one offline HTML page from result folders, and compares several of them");
  app->add_option("DIR", options->folders, "Result folders of other commands")->required();
  app->add_option("--out", options->file, "HTML file of the page; it needs no network")
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
