#pragma once

#include <dn/geo/read_file.h>
#include <dn/report/json_reader.h>

#include <filesystem>

namespace dn::apps {

/// The JSON of a file, within the limits of ParseJson. Throws InvalidInput for what is no regular
/// file or no JSON.
inline Json ReadJsonFile(const std::filesystem::path& file) {
  return ParseJson(ReadWholeFile(file, JsonLimits{}.bytes), file.string());
}

}  // namespace dn::apps
