#pragma once

#include <string>

namespace dn {

/// Words in lines of at most 100 characters, a newline at the end; `indent` stands before all lines
/// but the first.
std::string Wrapped(const std::string& text, const std::string& indent);

}  // namespace dn
