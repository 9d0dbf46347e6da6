#pragma once

#include <dn/report/document.h>

#include <filesystem>
#include <vector>

namespace dn {

/// Returns the page of a result folder, made from its JSON and text files alone. It is the
/// report.html that the command writes. Each number names the file and the key that it comes from.
/// Values in which two runs of the same work differ (timings, threads, output options) are left
/// out.
///
/// Throws InvalidInput if the folder has no report.json of a run that ended with results, or if one
/// of its files cannot be read.
Document MakePage(const std::filesystem::path& folder);

/// Returns a page that compares several results: their headlines, and for each two boresights the
/// difference, its sigma and its significance. Returns the page of the folder if there is only one.
Document MakePage(const std::vector<std::filesystem::path>& folders);

}  // namespace dn
