#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace dn {

/// Writes a file so that it appears complete or not at all: to a temporary name in the same
/// directory, flushed to disk, then renamed. Throws std::filesystem::filesystem_error naming the
/// path (disk full, not writable); nothing is left behind then.
void WriteFileAtomically(const std::filesystem::path& path, std::string_view content);

/// A directory cannot take results: another run writes into it, or a folder stands where a file
/// should go.
class UnusableOutput : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Whether a results folder may hold a file of this name: FILE or FOLDER/FILE, relative, without ".."
/// and control characters, and not hidden.
bool IsResultName(const std::string& name);

/// Collects the files of a result directory and publishes them together, all or none: Add stages a
/// file, Commit renames all of them; without Commit the destructor removes what was staged.
///
/// One run at a time: the directory is locked as long as the object lives (where its file system
/// knows locks). Files are staged in a directory inside it that only this user may enter and whose
/// name nobody can foresee; what a killed run left there, also half committed, is undone by the
/// next one. A commit that was not begun in this very directory is refused, never undone.
class OutputDirectory {
 public:
  /// Makes the directory if absent. Throws UnusableOutput when another run holds it, or the journal
  /// of a commit lies in it that no run has begun there;
  /// std::filesystem::filesystem_error when it cannot be made or written.
  explicit OutputDirectory(std::filesystem::path directory);
  ~OutputDirectory();
  OutputDirectory(const OutputDirectory&) = delete;
  OutputDirectory& operator=(const OutputDirectory&) = delete;

  /// Files that Add must not replace, under whatever name.
  void Protect(std::vector<std::filesystem::path> inputs) { inputs_ = std::move(inputs); }

  /// Stages a file; `name` may contain one level of sub-directory ("lidar/1_2.txt"). Throws
  /// InvalidInput for another name, InvalidConfig where it would replace a protected file.
  void Add(const std::string& name, std::string_view content);

  /// Path at which a file of this name is to be written before Commit, for one that is too large
  /// for memory. Throws as Add.
  std::filesystem::path Stage(const std::string& name);

  /// Makes every staged file visible. Throws with nothing changed when one cannot be.
  void Commit();

  /// Forgets what was staged.
  void Discard();

  /// Removes files, and the sub-directories that become empty thereby. What is absent, no file, or
  /// reached through a symbolic link is left alone.
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
