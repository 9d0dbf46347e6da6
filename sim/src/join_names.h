#pragma once

#include <string>
#include <vector>

namespace dn {

/// "a, b, c".
inline std::string JoinNames(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

}  // namespace dn
