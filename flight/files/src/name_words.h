#pragma once

#include <cctype>
#include <string>
#include <string_view>
#include <vector>

namespace dn::files_internal {

inline bool IsUpper(char c) { return std::isupper(static_cast<unsigned char>(c)) != 0; }
inline bool IsLower(char c) { return std::islower(static_cast<unsigned char>(c)) != 0; }

/// Splits a name into its words of letters and digits.
inline std::vector<std::string> SplitWords(std::string_view name) {
  std::vector<std::string> words(1);
  for (const char c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0) {
      words.back() += c;
    } else if (!words.back().empty()) {
      words.emplace_back();
    }
  }
  if (words.back().empty()) words.pop_back();
  return words;
}

}  // namespace dn::files_internal
