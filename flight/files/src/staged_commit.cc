#include "staged_commit.h"

#include <dn/flight/atomic_file.h>
#include <unistd.h>

#include <fstream>
#include <system_error>

namespace dn::internal {
namespace {

namespace fs = std::filesystem;

// Entries of the staging directory: the names of a commit in progress, and the files replaced so
// far.
constexpr const char* kJournal = ".commit";
constexpr const char* kReplaced = ".replaced";

bool Exists(const fs::path& path) {
  std::error_code none;
  return fs::symlink_status(path, none).type() != fs::file_type::not_found;
}

void ExpectRoom(const fs::path& directory, const std::string& name) {
  const fs::path target = directory / name;
  std::error_code none;
  if (fs::is_directory(fs::symlink_status(target, none))) {
    throw UnusableOutput("the folder " + target.string() +
                         " has the name of a result file; rename it, or give another --out");
  }
  const fs::path parent = target.parent_path();
  const bool below = parent != directory;
  if (below && Exists(parent) && !fs::is_directory(fs::symlink_status(parent, none))) {
    throw UnusableOutput("the file or link " + parent.string() +
                         " has the name of a result folder; rename it, or give another --out");
  }
}

// Saves a file before it is replaced: as a hard link, or by moving it if the file system has no
// hard links.
void Keep(const fs::path& file, const fs::path& kept) {
  if (!Exists(file)) return;
  fs::create_directories(kept.parent_path());
  if (::link(file.c_str(), kept.c_str()) != 0) fs::rename(file, kept);
}

std::vector<std::string> NamesInJournal(const fs::path& staging) {
  std::vector<std::string> names;
  std::ifstream in(staging / kJournal);
  for (std::string name; std::getline(in, name);) names.push_back(name);
  return names;
}

void UndoOne(const fs::path& staging, const std::string& name) {
  const fs::path target = staging.parent_path() / name;
  const fs::path kept = staging / kReplaced / name;
  std::error_code none;
  const bool moved = !Exists(staging / name);
  if (Exists(kept)) {
    fs::rename(kept, target, none);
  } else if (moved) {
    fs::remove(target, none);
  }
  const fs::path folder = fs::path(name).parent_path();
  // Only succeeds if it is empty.
  if (!folder.empty()) ::rmdir((staging.parent_path() / folder).c_str());
}

}  // namespace

void CommitStaged(const fs::path& staging, const std::vector<std::string>& names) {
  const fs::path directory = staging.parent_path();
  std::string journal;
  for (const std::string& name : names) {
    ExpectRoom(directory, name);
    journal += name + "\n";
  }
  WriteFileAtomically(staging / kJournal, journal);
  try {
    for (const std::string& name : names) {
      const fs::path target = directory / name;
      fs::create_directories(target.parent_path());
      Keep(target, staging / kReplaced / name);
      fs::rename(staging / name, target);
    }
  } catch (...) {
    UndoCommit(staging);
    throw;
  }
  fs::remove(staging / kJournal);
  std::error_code none;
  fs::remove_all(staging / kReplaced, none);
}

void UndoCommit(const fs::path& staging) {
  for (const std::string& name : NamesInJournal(staging)) UndoOne(staging, name);
  std::error_code none;
  fs::remove(staging / kJournal, none);
}

}  // namespace dn::internal
