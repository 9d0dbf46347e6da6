#include <dn/error.h>
#include <dn/files/atomic_file.h>
#include <dn/names.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <system_error>

#include "command.h"
#include "flight_draft.h"

namespace dn::apps {
namespace {

namespace fs = std::filesystem;

struct InitArguments {
  CommonOptions common;
  std::string folder;
};

const char* KindName(FileKind kind) {
  switch (kind) {
    case FileKind::kImu:
      return "inertial data";
    case FileKind::kGnss:
      return "GNSS data";
    case FileKind::kPairs:
      return "pairs";
    case FileKind::kTrajectory:
      return "a trajectory";
    case FileKind::kSmrmsg:
      return "standard deviations of a trajectory";
    case FileKind::kPointCloud:
      return "a point cloud";
    case FileKind::kUnknown:
      break;
  }
  return "not known";
}

std::vector<FileContent> LookAtFlightFolder(const fs::path& folder) {
  std::vector<FileContent> contents = InspectFolder(folder);
  std::error_code none;
  if (!fs::is_directory(folder / "lidar", none)) return contents;
  for (FileContent& content : InspectFolder(folder / "lidar")) {
    if (content.kind == FileKind::kPairs) contents.push_back(std::move(content));
  }
  return contents;
}

void ExpectFolder(const fs::path& folder) {
  std::error_code none;
  if (!fs::is_directory(folder, none)) {
    throw InvalidConfig("there is no folder '" + folder.string() + "'");
  }
  const fs::path file = folder / "flight.yaml";
  if (!fs::exists(fs::symlink_status(file, none))) return;
  throw InvalidConfig("the folder has a flight.yaml, which is left as it is; remove or rename it",
                      FileLocation{file.string(), 0, 0});
}

/// Prints what each file of the folder is.
void PrintContents(const fs::path& folder, const std::vector<FileContent>& contents,
                   const FlightDraft& draft) {
  for (const FileContent& content : contents) {
    if (content.kind == FileKind::kUnknown || draft.Rejected(content)) continue;
    fmt::print("found    {:<22} {}\n", content.file.lexically_relative(folder).string(),
               KindName(content.kind));
  }
  for (const StripScanner& scanner : FindStripFolders(folder)) {
    for (const fs::path& strip : scanner.strips) {
      fmt::print("found    {:<22} a strip\n", strip.lexically_relative(folder).string());
    }
  }
  for (const std::string& text : draft.notes()) fmt::print("note     {}\n", text);
}

/// Throws InvalidInput if the draft has no data from which a command could start.
void ExpectData(const fs::path& folder, const std::vector<FileContent>& contents,
                const FlightDraft& draft) {
  if (!draft.empty()) return;
  PrintContents(folder, contents, draft);
  std::fflush(stdout);
  const bool listed = !contents.empty() || !FindStripFolders(folder).empty();
  const std::string what = listed ? " has only the files listed above" : " is empty";
  throw InvalidInput(folder.string() + what +
                     ": add a trajectory, or inertial data and GNSS positions of the flight "
                     "(docs/reference/formats.md)");
}

void Init(const InitArguments& options, Run& run) {
  const fs::path folder = options.folder;
  ExpectFolder(folder);
  run.progress().Stage("looking at " + folder.string());
  const std::vector<FileContent> contents = LookAtFlightFolder(folder);
  FlightDraft draft(folder, contents);
  ExpectData(folder, contents, draft);
  draft.Settle();
  ExpectData(folder, contents, draft);
  WriteFileAtomically(folder / "flight.yaml", draft.Text());
  PrintContents(folder, contents, draft);
  for (const std::string& text : draft.found()) fmt::print("settled  {}\n", text);
  for (const std::string& text : draft.Missing()) fmt::print("missing  {}\n", text);
  fmt::print("wrote    {}\nnext     dn check {}\n", (folder / "flight.yaml").string(),
             QuoteForShell(folder.string()));
  run.report()["missing"] = draft.Missing();
}

}  // namespace

void AddInit(CLI::App* program, Action* action) {
  auto options = std::make_shared<InitArguments>();
  CLI::App* app = program->add_subcommand(
      "init", "Writes a commented flight.yaml for the data files in a folder");
  app->add_option("FOLDER", options->folder, "Folder with the data; flight.yaml is written there")
      ->required();
  AddCommonOptions(app, &options->common, false);
  app->footer("Example: dn init flight && dn check flight && dn smooth flight --out result");
  app->callback([options, action] {
    *action = [options] {
      options->common.inputs = FlightInputs(options->folder, {});
      return Execute("init", options->common, [&](Run& run) { Init(*options, run); });
    };
  });
}

}  // namespace dn::apps
