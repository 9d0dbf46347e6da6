#include "scanner_list.h"

#include <dn/files/scanners.h>
#include <dn/names.h>

#include <algorithm>
#include <utility>

#include "config_sections.h"

namespace dn::files_internal {
namespace {

/// Returns the index of a scanner of the list.
std::size_t FindScanner(const YamlValue& value, const std::vector<std::string>& names) {
  const std::string name = ReadName(value);
  if (names.empty()) value.Fail("needs a list of scanners under lidar");
  const auto at = std::find(names.begin(), names.end(), name);
  if (at == names.end()) {
    value.Fail("unknown scanner '" + name + "'; did you mean '" + NearestName(name, names) + "'?");
  }
  return static_cast<std::size_t>(at - names.begin());
}

void ExpectSameLoss(const YamlValue& item, const LidarConfig& first, const LidarConfig& other) {
  if (other.robust == first.robust) return;
  item["robust"].Fail("all scanners must have the same robust loss");
}

PairsBetween ReadBetween(const YamlValue& item, const std::vector<std::string>& names,
                         const std::vector<LidarConfig>& scanners) {
  item.ExpectMap({"scanners", "p2p", "sigma_p_m"});
  const std::vector<YamlValue> two = item["scanners"].List(2);
  if (two.size() != 2) item["scanners"].Fail("must name two scanners: [a, b]");
  PairsBetween between;
  between.scanner_i = FindScanner(two[0], names);
  between.scanner_j = FindScanner(two[1], names);
  if (between.scanner_i == between.scanner_j) two[1].Fail("must be another scanner");
  between.p2p = item["p2p"] ? ReadPairPatterns(item["p2p"])
                            : std::vector<std::string>{"lidar_" + names[between.scanner_i] + "_" +
                                                       names[between.scanner_j] + "/*.txt"};
  between.sigma_p_m = item["sigma_p_m"]
                          ? ReadPositive(item["sigma_p_m"])
                          : SigmaBetween(scanners[between.scanner_i], scanners[between.scanner_j]);
  return between;
}

std::vector<PairsBetween> ReadPairsBetween(const YamlValue& section,
                                           const std::vector<std::string>& names,
                                           const std::vector<LidarConfig>& scanners) {
  std::vector<PairsBetween> all;
  if (!section) return all;
  for (const YamlValue& item : section.List(kMostScanners * kMostScanners)) {
    const PairsBetween between = ReadBetween(item, names, scanners);
    const auto same = [&](const PairsBetween& other) {
      return std::minmax(other.scanner_i, other.scanner_j) ==
             std::minmax(between.scanner_i, between.scanner_j);
    };
    if (std::any_of(all.begin(), all.end(), same)) item.Fail("these two scanners are given twice");
    all.push_back(between);
  }
  return all;
}

std::vector<LidarConfig> ReadList(const YamlValue& section, bool body_is_flu,
                                  std::vector<std::string>* names) {
  std::vector<LidarConfig> scanners;
  for (const YamlValue& item : section.List(kMostScanners)) {
    const std::string name = ReadScannerName(item, *names);
    names->push_back(name);
    scanners.push_back(ReadLidarSection(item, body_is_flu, name));
    ExpectSameLoss(item, scanners.front(), scanners.back());
  }
  if (scanners.empty()) section.Fail("must have at least one scanner");
  return scanners;
}

}  // namespace

std::vector<std::string> ReadScanners(const YamlValue& root, FlightConfig* config) {
  std::vector<std::string> names;
  const YamlValue section = root["lidar"], selected = root["scanner"];
  if (section && section.IsMap()) {
    config->lidar = ReadLidarSection(section, config->body_is_flu, "");
  } else if (section) {
    std::vector<LidarConfig> scanners = ReadList(section, config->body_is_flu, &names);
    config->pairs_between = ReadPairsBetween(root["pairs_between"], names, scanners);
    config->lidar = scanners.front();
    config->more_scanners.assign(scanners.begin() + 1, scanners.end());
  }
  if (root["pairs_between"] && names.empty()) {
    root["pairs_between"].Fail("needs a list of scanners under lidar");
  }
  if (!selected) return names;
  KeepScanner(FindScanner(selected, names), config);
  return names;
}

}  // namespace dn::files_internal
