#include <dn/error.h>
#include <dn/flight/atomic_file.h>

#include <algorithm>
#include <iterator>
#include <system_error>

#include "temporary_name.h"

namespace dn {
namespace {

namespace fs = std::filesystem;

void CheckName(const std::string& name) {
  const fs::path path(name);
  const auto depth = std::distance(path.begin(), path.end());
  const bool climbs = std::find(path.begin(), path.end(), "..") != path.end();
  if (depth < 1 || depth > 2 || path.is_absolute() || climbs || !path.has_filename()) {
    throw InvalidInput("result file name '" + name +
                       "' must be FILE or FOLDER/FILE inside the output directory");
  }
}

}  // namespace

OutputDirectory::OutputDirectory(fs::path directory) : directory_(std::move(directory)) {
  fs::create_directories(directory_);
  staging_ = internal::TemporarySibling(directory_ / "staging");
  fs::create_directory(staging_);
}

OutputDirectory::~OutputDirectory() {
  std::error_code none;
  fs::remove_all(staging_, none);
}

void OutputDirectory::Add(const std::string& name, std::string_view content) {
  CheckName(name);
  const fs::path staged = staging_ / name;
  fs::create_directories(staged.parent_path());
  WriteFileAtomically(staged, content);
  if (std::find(names_.begin(), names_.end(), name) == names_.end()) names_.push_back(name);
}

void OutputDirectory::Commit() {
  for (const std::string& name : names_) {
    const fs::path target = directory_ / name;
    fs::create_directories(target.parent_path());
    fs::rename(staging_ / name, target);
  }
  names_.clear();
}

}  // namespace dn
