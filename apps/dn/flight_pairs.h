#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace dn::apps {

/// Returns the name of the folder with the pairs between two flights.
std::string BetweenFolder(const std::string& first, const std::string& second);

/// Returns the --set value `ties=...` of each flight for the pairs that `dn match A B` wrote into a
/// folder. It is empty for a flight without such pairs. `names` are those of the flights. Each two
/// flights get up to 100 pairs, and fewer if there are many flights. Throws InvalidConfig if the
/// folder has no pairs between any two of them.
std::vector<std::string> FindFlightPairs(const std::filesystem::path& folder,
                                         const std::vector<std::string>& names);

}  // namespace dn::apps
