#pragma once

#include <string>
#include <vector>

namespace dn {

/// The candidate nearest to `word` by edit distance; empty when there are no candidates.
std::string NearestName(const std::string& word, const std::vector<std::string>& candidates);

/// "a, b, c".
std::string JoinNames(const std::vector<std::string>& names);

}  // namespace dn
