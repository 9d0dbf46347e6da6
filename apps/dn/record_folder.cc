#include "record_folder.h"

#include <dn/files/atomic_file.h>
#include <fmt/format.h>

#include <system_error>
#include <vector>

#include "output_folder.h"
#include "sha256.h"

namespace dn::apps {
namespace {

namespace fs = std::filesystem;

constexpr const char* kHashKey = "made_from";

}  // namespace

RecordFolder::RecordFolder(fs::path folder, const Json& made_from)
    : folder_(std::move(folder)), hash_(MadeFromHash(made_from)) {
  ExpectRealFolder(folder_);
  const fs::path key = MadeFromFile(folder_);
  const std::string text = FormatJson(made_from);
  if (IsThere(key) && ReadWholeFile(key, JsonLimits{}.bytes) != text) {
    throw InvalidConfig(folder_.string() +
                        " contains flights of another scenario, version or option, or of another "
                        "build of this version (see " +
                        key.string() + "); give another --out, or delete it");
  }
  fs::create_directories(folder_);
  RemoveUnfinished();
  WriteFileAtomically(key, text);
}

void RecordFolder::Write(std::uint64_t number, Json record) const {
  record[kHashKey] = hash_;
  WriteFileAtomically(RecordFile(folder_, number), record.dump() + "\n");
}

fs::path RecordFolder::RecordFile(const fs::path& folder, std::uint64_t number) {
  return folder / fmt::format("{:06}.json", number);
}

bool RecordFolder::IsThere(const fs::path& file) {
  std::error_code none;
  return fs::exists(file, none);
}

fs::path RecordFolder::MadeFromFile(const fs::path& folder) { return folder / "made_from.json"; }

Json RecordFolder::MadeFrom(const fs::path& folder) {
  const fs::path key = MadeFromFile(folder);
  Json made_from = ReadJsonFile(key);
  if (!made_from.is_object()) {
    throw InvalidInput("it does not describe the flights of this folder", {key.string()});
  }
  return made_from;
}

std::string RecordFolder::MadeFromHash(const Json& made_from) {
  return Sha256Hex(FormatJson(made_from));
}

void RecordFolder::Refuse(const InvalidInput& error) {
  throw InvalidInput(std::string("not the record of this flight: ") + error.what() +
                         "; delete the file to simulate the flight again",
                     error.where());
}

void RecordFolder::ExpectHash(const JsonPlace& record, const std::string& hash) {
  const JsonPlace made_from = record.At(kHashKey);
  if (made_from.Text() != hash) {
    made_from.Fail("is of another scenario, option, version or build than made_from.json");
  }
}

// Removes temporary files of killed runs. The lock of --out keeps other runs out of the folder.
void RecordFolder::RemoveUnfinished() const {
  std::vector<fs::path> unfinished;
  for (const auto& entry : fs::directory_iterator(folder_)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with('.') && name.ends_with(".part")) unfinished.push_back(entry.path());
  }
  std::error_code none;  // a folder of such a name is not one of these files
  for (const fs::path& file : unfinished) fs::remove(file, none);
}

}  // namespace dn::apps
