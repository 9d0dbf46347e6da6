#pragma once

#include <dn/error.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace dn {

/// Writes a file so that it appears complete or not at all: to a temporary name in the same
/// directory, flushed to disk, then renamed. On failure (disk full, not writable) throws
/// std::filesystem::filesystem_error with the path and leaves no file.
void WriteFileAtomically(const std::filesystem::path& path, std::string_view content);

/// Thrown if a directory cannot take results: another run is writing into it, or a folder has the
/// name of a result file.
class UnusableOutput : public Error {
 public:
  using Error::Error;
};

/// Returns whether a results folder may contain a file of this name: FILE or FOLDER/FILE, relative,
/// without ".." and control characters, and not hidden.
bool IsResultName(const std::string& name);

/// Collects the files of a result directory and publishes them together, all or none. Add stages a
/// file, Commit renames all of them; without Commit the destructor removes the staged files.
///
/// Only one run may write at a time: the directory is locked as long as the object exists, if the
/// file system supports locks. Files are staged in a subdirectory that only this user may enter and
/// whose name is random. The next run removes the staged files of a killed run, and undoes its
/// half-finished commit. A journal of a commit that was not begun in this directory is refused.
class OutputDirectory {
 public:
  /// Creates the directory if it does not exist. Throws UnusableOutput if another run has locked
  /// it, or if it contains the journal of a commit that no run has begun there. Throws
  /// std::filesystem::filesystem_error if it cannot be created or written.
  explicit OutputDirectory(std::filesystem::path directory);
  ~OutputDirectory();
  OutputDirectory(const OutputDirectory&) = delete;
  OutputDirectory& operator=(const OutputDirectory&) = delete;

  /// Sets the input files that Add must not replace, under whatever name.
  void Protect(std::vector<std::filesystem::path> inputs) { inputs_ = std::move(inputs); }

  /// Stages a file; `name` may contain one level of subdirectory ("lidar/1_2.txt"). Throws
  /// InvalidInput for other names, InvalidConfig if the file would replace a protected one.
  void Add(const std::string& name, std::string_view content);

  /// Returns the path to which a file that is too large for memory is to be written before Commit.
  /// Throws like Add.
  std::filesystem::path Stage(const std::string& name);

  /// Publishes all staged files. If this fails, throws and leaves the directory unchanged.
  void Commit();

  /// Removes the staged files.
  void Discard();

  /// Removes result files and the subdirectories that become empty. Ignores names that are absent,
  /// are not a file, or are reached through a symbolic link.
  void Remove(const std::vector<std::string>& names) const;

  const std::filesystem::path& path() const { return directory_; }
  const std::filesystem::path& staging() const { return staging_; }
  const std::vector<std::string>& staged() const { return names_; }

 private:
  std::filesystem::path directory_;
  int lock_ = -1;
  std::filesystem::path staging_;
  std::vector<std::string> names_;
  std::vector<std::filesystem::path> inputs_;
};

}  // namespace dn
