#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace dn::apps {

/// Returns the content of a file, or an empty string if it cannot be read.
inline std::string ReadText(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace dn::apps
