#pragma once

#include <dn/report/document.h>

#include <filesystem>
#include <vector>

namespace dn {

/// The page of a result folder, from its JSON and text files alone: what the command that made it
/// writes as report.html. Numbers name the file and the key that they come from.
///
/// What two runs of one work differ in (timings, threads, options of the output) is left out.
///
/// Throws InvalidInput where the folder holds no report.json of a run that has ended with results,
/// or a file of it cannot be read.
Document PageOf(const std::filesystem::path& folder);

/// Several side by side: their headlines, and of each two that have a boresight the difference, its
/// sigma and whether it is significant. One folder: its PageOf.
Document PageOf(const std::vector<std::filesystem::path>& folders);

}  // namespace dn
