#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace dn::internal {

/// False for a link to a directory.
bool IsRealDirectory(const std::filesystem::path& path);

/// Moves files from a staging directory into the directory above it. When one of them cannot be
/// moved, those before it are moved back and what they replaced is restored. Throws UnusableOutput
/// before anything is changed where a folder stands in the way of a file.
void CommitStaged(const std::filesystem::path& staging, const std::vector<std::string>& names);

/// Undoes a commit into the directory above that was cut off. Nothing to do without one. Throws
/// UnusableOutput, with nothing changed, for a journal that was not written in these two
/// directories, that names a file outside them, or where a link stands for a folder.
void UndoCommit(const std::filesystem::path& staging);

}  // namespace dn::internal
