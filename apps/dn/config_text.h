#pragma once

#include <dn/error.h>
#include <dn/geo/read_file.h>

#include <string>

namespace dn::apps {

/// Returns the content of a configuration file, at most 1 MiB. Throws InvalidConfig if the file
/// cannot be read.
inline std::string ReadConfigText(const std::string& file) {
  constexpr std::size_t kMostBytes = std::size_t{1} << 20;
  try {
    return ReadWholeFile(file, kMostBytes);
  } catch (const InvalidInput& error) {
    throw InvalidConfig(error.what(), error.where());
  }
}

}  // namespace dn::apps
