#include "flight_pairs.h"

#include <dn/error.h>
#include <dn/files/flight_config.h>
#include <dn/files/yaml_sections.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstddef>

#include "output_folder.h"

namespace dn::apps {
namespace {

namespace fs = std::filesystem;

// The pairs of all flights are adjusted with a dense covariance.
constexpr long kMostPairs = 1000, kFewestPairs = 10;

/// Pairs between two flights: `first` measured the first ends.
struct FlightPair {
  std::size_t first = 0, second = 0;
  fs::path folder;
};

bool HasPairFiles(const fs::path& folder) {
  std::error_code error;
  const fs::directory_iterator files(folder, error);
  return !error && std::any_of(begin(files), end(files), [](const fs::directory_entry& entry) {
    return entry.path().extension() == ".txt";
  });
}

std::vector<FlightPair> FindFolders(const fs::path& folder, const std::vector<std::string>& names) {
  std::vector<FlightPair> found;
  for (std::size_t i = 0; i < names.size(); ++i) {
    for (std::size_t j = 0; j < names.size(); ++j) {
      const fs::path pairs = BetweenFolder(names[i], names[j]);
      if (i != j && HasPairFiles(folder / pairs)) {
        found.push_back({i, j, fs::absolute(folder / pairs).lexically_normal()});
      }
    }
  }
  return found;
}

std::string TieText(const FlightPair& pair, bool second, long count) {
  return fmt::format("{{p2p: [{}], end: {}, count: {}}}",
                     QuoteYaml((pair.folder / "*.txt").string()), second ? "j" : "i", count);
}

}  // namespace

std::string BetweenFolder(const std::string& first, const std::string& second) {
  return fmt::format("between_{}_{}", FolderName(first), FolderName(second));
}

std::vector<std::string> FindFlightPairs(const fs::path& folder,
                                         const std::vector<std::string>& names) {
  const std::vector<FlightPair> pairs = FindFolders(folder, names);
  if (pairs.empty()) {
    throw InvalidConfig(fmt::format(
        "{} has no pairs between these flights, in a folder like {}; `dn match` with these flights "
        "writes them",
        folder.string(), BetweenFolder(names[0], names[1])));
  }
  const long count =
      std::clamp(kMostPairs / static_cast<long>(pairs.size()), kFewestPairs, TieFiles::kUsualCount);
  std::vector<std::string> ties(names.size());
  const auto add = [&](std::size_t flight, const std::string& text) {
    ties[flight] += (ties[flight].empty() ? "" : ", ") + text;
  };
  for (const FlightPair& pair : pairs) {
    add(pair.first, TieText(pair, false, count));
    add(pair.second, TieText(pair, true, count));
  }
  for (std::string& text : ties) {
    if (!text.empty()) text = fmt::format("ties=[{}]", text);
  }
  return ties;
}

}  // namespace dn::apps
