#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace dn::files_internal {

/// Returns whether the path is a directory; false for a link to a directory.
bool IsRealDirectory(const std::filesystem::path& path);

/// Moves files from a staging directory into the directory above it. If a file cannot be moved, the
/// earlier ones are moved back and the replaced files are restored. Throws UnusableOutput before
/// any change if a folder has the name of a file.
void CommitStaged(const std::filesystem::path& staging, const std::vector<std::string>& names);

/// Undoes an interrupted commit into the directory above; does nothing if there is no such commit.
/// Throws UnusableOutput, with nothing changed, for a journal that was not written in these two
/// directories or that names a file outside them. Also throws if a link takes the place of a
/// folder.
void UndoCommit(const std::filesystem::path& staging);

}  // namespace dn::files_internal
