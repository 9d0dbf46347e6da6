#include <dn/error.h>
#include <dn/files/atomic_file.h>
#include <dn/names.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <iterator>
#include <system_error>

#include "staged_commit.h"

namespace dn {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kStagingPrefix = ".dn-staging-";
constexpr std::string_view kStagingRandom = "XXXXXX";

void CheckName(const std::string& name) {
  if (IsResultName(name)) return;
  throw InvalidInput("result file name '" + name +
                     "' must be FILE or FOLDER/FILE inside the output directory");
}

[[noreturn]] void ThrowErrno(const char* what, const fs::path& path) {
  throw fs::filesystem_error(what, path, std::error_code(errno, std::generic_category()));
}

/// Locks a directory and returns its descriptor; -1 on a file system without locks.
int Lock(const fs::path& directory) {
  const int fd = ::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) ThrowErrno("cannot open", directory);
  if (::flock(fd, LOCK_EX | LOCK_NB) == 0) return fd;
  const bool held = errno == EWOULDBLOCK;
  ::close(fd);
  if (!held) return -1;
  throw UnusableOutput("another run is writing into " + directory.string() +
                       "; wait until it ends, or give another --out");
}

bool IsMine(const fs::path& path) {
  struct stat status {};
  return ::lstat(path.c_str(), &status) == 0 && S_ISDIR(status.st_mode) &&
         status.st_uid == ::geteuid();
}

/// Removes the files that killed runs left. While this run has the lock, no other run is active.
void Sweep(const fs::path& directory) {
  std::vector<fs::path> left;
  for (const auto& entry : fs::directory_iterator(directory)) {
    const std::string name = entry.path().filename().string();
    if (name.size() == kStagingPrefix.size() + kStagingRandom.size() &&
        name.starts_with(kStagingPrefix) && IsMine(entry.path())) {
      left.push_back(entry.path());
    }
  }
  for (const fs::path& staging : left) {
    files_internal::UndoCommit(staging);
    std::error_code none;
    fs::remove_all(staging, none);
  }
}

fs::path MakeStaging(const fs::path& directory) {
  std::string name =
      (directory / (std::string(kStagingPrefix) + std::string(kStagingRandom))).string();
  if (::mkdtemp(name.data()) == nullptr) ThrowErrno("cannot write into", directory);
  return name;
}

}  // namespace

bool IsResultName(const std::string& name) {
  const fs::path path(name);
  const auto depth = std::distance(path.begin(), path.end());
  const bool climbs = std::find_if(path.begin(), path.end(), [](const fs::path& part) {
                        return part == ".." || part == ".";
                      }) != path.end();
  return depth >= 1 && depth <= 2 && !path.is_absolute() && !climbs && path.has_filename() &&
         name.front() != '.' && !HasControls(name);
}

OutputDirectory::OutputDirectory(fs::path directory) : directory_(std::move(directory)) {
  fs::create_directories(directory_);
  lock_ = Lock(directory_);
  try {
    if (lock_ >= 0) Sweep(directory_);
    staging_ = MakeStaging(directory_);
  } catch (...) {
    if (lock_ >= 0) ::close(lock_);
    throw;
  }
}

OutputDirectory::~OutputDirectory() {
  std::error_code none;
  fs::remove_all(staging_, none);
  if (lock_ >= 0) ::close(lock_);
}

void OutputDirectory::Add(const std::string& name, std::string_view content) {
  WriteFileAtomically(Stage(name), content);
}

fs::path OutputDirectory::Stage(const std::string& name) {
  CheckName(name);
  for (const fs::path& input : inputs_) {
    std::error_code none;
    if (!fs::equivalent(directory_ / name, input, none)) continue;
    throw InvalidConfig("the result file " + (directory_ / name).string() +
                        " would replace the input " + input.string() + "; give another --out");
  }
  fs::path staged = staging_ / name;
  // The staging directory itself is not created again: a forced end may have removed it.
  if (staged.parent_path() != staging_) fs::create_directory(staged.parent_path());
  if (std::find(names_.begin(), names_.end(), name) == names_.end()) names_.push_back(name);
  return staged;
}

void OutputDirectory::Commit() {
  files_internal::CommitStaged(staging_, names_);
  names_.clear();
}

void OutputDirectory::Discard() {
  for (const std::string& name : names_) fs::remove(staging_ / name);
  names_.clear();
}

void OutputDirectory::Remove(const std::vector<std::string>& names) const {
  for (const std::string& name : names) {
    if (!IsResultName(name)) continue;
    const fs::path file = directory_ / name;
    const bool in_folder = fs::path(name).has_parent_path();
    if (in_folder && !files_internal::IsRealDirectory(file.parent_path())) continue;
    ::unlink(file.c_str());
    if (in_folder) ::rmdir(file.parent_path().c_str());
  }
}

}  // namespace dn
