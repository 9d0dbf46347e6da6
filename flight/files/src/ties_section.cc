#include "config_sections.h"

namespace dn::files_internal {
namespace {

constexpr std::size_t kMostFlights = 1000;
constexpr long long kMostTies = 1000;

TieFiles ReadTieFiles(const YamlValue& item) {
  item.ExpectMap({"p2p", "end", "count"});
  TieFiles files;
  if (!item["p2p"]) item.Fail("needs p2p, the pair files");
  files.p2p = ReadPairPatterns(item["p2p"]);
  if (!item["end"]) item.Fail("needs end, the end of the pairs that this flight measured: i or j");
  files.second = item["end"].Choice(EndWords());
  if (!item["count"]) return files;
  const long long count = item["count"].Integer(1);
  if (count > kMostTies) item["count"].Fail("must be at most " + std::to_string(kMostTies));
  files.count = static_cast<long>(count);
  return files;
}

}  // namespace

std::vector<TieFiles> ReadTiesSection(const YamlValue& section) {
  std::vector<TieFiles> ties;
  for (const YamlValue& item : section.List(kMostFlights)) ties.push_back(ReadTieFiles(item));
  return ties;
}

}  // namespace dn::files_internal
