#include "record_folder.h"

#include <dn/flight/atomic_file.h>
#include <fmt/format.h>

#include "read_text.h"

namespace dn::apps {
namespace {

namespace fs = std::filesystem;

constexpr const char* kKeyName = "made_from.json";

}  // namespace

RecordFolder::RecordFolder(fs::path folder, const Json& made_from) : folder_(std::move(folder)) {
  const fs::path key = folder_ / kKeyName;
  const std::string text = FormatJson(made_from);
  if (fs::exists(key) && ReadText(key) != text) {
    throw InvalidConfig(folder_.string() +
                        " holds flights of another scenario, version or option (see " +
                        key.string() + "); give another --out, or delete it");
  }
  fs::create_directories(folder_);
  RemoveUnfinished();
  WriteFileAtomically(key, text);
}

void RecordFolder::Write(std::uint64_t number, const Json& record) const {
  WriteFileAtomically(FileOf(folder_, number), record.dump() + "\n");
}

fs::path RecordFolder::FileOf(const fs::path& folder, std::uint64_t number) {
  return folder / fmt::format("{:06}.json", number);
}

Json RecordFolder::MadeFrom(const fs::path& folder) {
  const fs::path key = folder / kKeyName;
  Json made_from = Json::parse(ReadText(key), nullptr, false);
  if (!made_from.is_object()) {
    throw InvalidInput("it does not say what flights lie here", {key.string()});
  }
  return made_from;
}

Json RecordFolder::ParseFile(const fs::path& file) { return Json::parse(ReadText(file)); }

// Removes temporary files of killed runs. The lock of --out keeps other runs out of the folder.
void RecordFolder::RemoveUnfinished() const {
  std::vector<fs::path> unfinished;
  for (const auto& entry : fs::directory_iterator(folder_)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with('.') && name.ends_with(".part")) unfinished.push_back(entry.path());
  }
  for (const fs::path& file : unfinished) fs::remove(file);
}

}  // namespace dn::apps
