#pragma once

#include <dn/geo/read_file.h>
#include <dn/report/json_reader.h>

#include <filesystem>

namespace dn::apps {

/// Reads the JSON of a file within the limits of ParseJson. Throws InvalidInput for a file that is
/// not regular or not JSON.
inline Json ReadJsonFile(const std::filesystem::path& file) {
  return ParseJson(ReadWholeFile(file, JsonLimits{}.bytes), file.string());
}

}  // namespace dn::apps
