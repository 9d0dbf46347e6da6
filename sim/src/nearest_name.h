#pragma once

#include <string>
#include <vector>

namespace dn {

/// The one of `names` with the fewest edits (insert, delete, replace) from `name`; empty when there
/// is none.
std::string NearestName(const std::string& name, const std::vector<std::string>& names);

/// "a, b, c".
std::string JoinNames(const std::vector<std::string>& names);

}  // namespace dn
