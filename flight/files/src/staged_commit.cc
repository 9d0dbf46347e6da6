#include "staged_commit.h"

#include <dn/error.h>
#include <dn/files/atomic_file.h>
#include <dn/geo/read_file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <sstream>
#include <system_error>

namespace dn::files_internal {
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
  if (IsRealDirectory(target)) {
    throw UnusableOutput("the folder " + target.string() +
                         " has the name of a result file; rename it, or give another --out");
  }
  const fs::path parent = target.parent_path();
  const bool below = parent != directory;
  if (below && Exists(parent) && !IsRealDirectory(parent)) {
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

// Inode numbers bind a journal to the two directories in which it was written. They differ in a
// copy of the directories, and in a journal that somebody else has put there.
std::string FirstLine(const fs::path& staging) {
  std::string line = "dn.commit/1";
  for (const fs::path& directory : {staging.parent_path(), staging}) {
    struct stat status {};
    if (::stat(directory.c_str(), &status) == 0) line += " " + std::to_string(status.st_ino);
  }
  return line;
}

[[noreturn]] void Refuse(const fs::path& staging, const std::string& why) {
  throw UnusableOutput((staging / kJournal).string() +
                       " is not the journal of a run that was interrupted in this folder: " + why +
                       "; delete " + staging.string() + ", or give another --out");
}

std::string JournalText(const fs::path& staging) {
  constexpr std::uintmax_t kMostBytes = std::uintmax_t{16} << 20;
  const fs::path journal = staging / kJournal;
  std::error_code none;
  if (fs::is_symlink(fs::symlink_status(journal, none))) Refuse(staging, "it is a link");
  try {
    return ReadWholeFile(journal, kMostBytes);
  } catch (const InvalidInput& error) {
    Refuse(staging, error.what());
  }
}

// A folder between the results directory and one of its files may be absent, but must not be a
// link.
void ExpectNoLink(const fs::path& staging, const fs::path& folder) {
  if (!Exists(folder) || IsRealDirectory(folder)) return;
  Refuse(staging, folder.string() + " is not a folder");
}

std::vector<std::string> NamesInJournal(const fs::path& staging) {
  std::vector<std::string> names;
  if (!Exists(staging / kJournal)) return names;
  std::istringstream in(JournalText(staging));
  std::string name;
  if (!std::getline(in, name) || name != FirstLine(staging)) {
    Refuse(staging, "it was written for another folder");
  }
  ExpectNoLink(staging, staging / kReplaced);
  while (std::getline(in, name)) {
    if (!IsResultName(name)) Refuse(staging, "it names a file that is not a result");
    for (const fs::path& from : {staging.parent_path(), staging, staging / kReplaced}) {
      ExpectNoLink(staging, (from / name).parent_path());
    }
    names.push_back(name);
  }
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
  // rmdir only succeeds if the folder is empty.
  if (!folder.empty()) ::rmdir((staging.parent_path() / folder).c_str());
}

}  // namespace

bool IsRealDirectory(const fs::path& path) {
  std::error_code none;
  return fs::is_directory(fs::symlink_status(path, none));
}

void CommitStaged(const fs::path& staging, const std::vector<std::string>& names) {
  const fs::path directory = staging.parent_path();
  std::string journal = FirstLine(staging) + "\n";
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

}  // namespace dn::files_internal
