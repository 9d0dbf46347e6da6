#pragma once

#include <string>

namespace dn {

/// Returns the words in lines of at most 100 characters with a final newline. All lines but the
/// first start with `indent`.
std::string WrapText(const std::string& text, const std::string& indent);

}  // namespace dn
