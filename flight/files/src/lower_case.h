#pragma once

#include <cctype>
#include <string>
#include <string_view>

namespace dn::files_internal {

/// Returns a text with its ASCII letters in lower case.
inline std::string LowerCase(std::string_view text) {
  std::string lower;
  for (const char c : text) lower += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

}  // namespace dn::files_internal
