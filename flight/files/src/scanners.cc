#include <dn/effects/effect_table.h>
#include <dn/files/scanners.h>
#include <dn/names.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "config_sections.h"

namespace dn {
namespace {

bool BelongsToScanner(const EstimateEntry& entry) {
  const EffectSpec* effect = FindEffect(entry.unknown);
  return effect == nullptr || effect->sensor == EffectSensor::kLidar;
}

void ExpectScanner(const EstimateEntry& entry, const std::vector<std::string>& names) {
  if (entry.scanner.empty()) return;
  if (!BelongsToScanner(entry)) {
    throw InvalidConfig("estimate: '" + entry.unknown + "' is not an unknown of a scanner",
                        entry.where);
  }
  if (HasName(names, entry.scanner)) return;
  throw InvalidConfig(
      "estimate: unknown scanner '" + entry.scanner + "'" +
          (names.empty() ? "; lidar is not a list of scanners"
                         : "; did you mean '" + NearestName(entry.scanner, names) + "'?"),
      entry.where);
}

}  // namespace

std::size_t NumScanners(const FlightConfig& config) {
  return config.lidar ? 1 + config.more_scanners.size() : 0;
}

const LidarConfig& ScannerAt(const FlightConfig& config, std::size_t k) {
  return k == 0 ? *config.lidar : config.more_scanners[k - 1];
}

void KeepScanner(std::size_t k, FlightConfig* config) {
  config->lidar = LidarConfig(ScannerAt(*config, k));
  config->more_scanners.clear();
  config->pairs_between.clear();
}

double SigmaBetween(const LidarConfig& i, const LidarConfig& j) {
  return std::max(files_internal::kLeastSigmaM,
                  std::sqrt(0.5 * (i.sigma_p_m * i.sigma_p_m + j.sigma_p_m * j.sigma_p_m)));
}

LidarConfig& ScannerAt(FlightConfig& config, std::size_t k) {
  return k == 0 ? *config.lidar : config.more_scanners[k - 1];
}

std::vector<std::string> ScannerNames(const FlightConfig& config) {
  std::vector<std::string> names;
  for (std::size_t k = 0; k < NumScanners(config); ++k) names.push_back(ScannerAt(config, k).name);
  return names;
}

std::string ScannerName(const FlightConfig& config, std::string_view unknown, std::size_t k) {
  const std::string name(unknown);
  return k == 0 ? name : name + "/" + ScannerAt(config, k).name;
}

std::size_t FindScanner(const FlightConfig& config, std::string_view name) {
  const std::size_t slash = name.find('/');
  if (slash == std::string_view::npos) return 0;
  for (std::size_t k = 1; k < NumScanners(config); ++k) {
    if (ScannerAt(config, k).name == name.substr(slash + 1)) return k;
  }
  return 0;
}

void AssignScanners(const std::vector<std::string>& all, FlightConfig* config) {
  std::vector<EstimateEntry> assigned;
  for (const EstimateEntry& entry : config->estimate) {
    ExpectScanner(entry, all);
    if (all.empty() || !BelongsToScanner(entry)) {
      assigned.push_back(entry);
      continue;
    }
    for (std::size_t k = 0; k < NumScanners(*config); ++k) {
      EstimateEntry own = entry;
      own.scanner = ScannerAt(*config, k).name;
      own.unknown = ScannerName(*config, entry.unknown.substr(0, entry.unknown.find('/')), k);
      if (entry.scanner.empty() || entry.scanner == own.scanner) assigned.push_back(own);
    }
  }
  config->estimate = std::move(assigned);
}

void ExpectOneScanner(const FlightConfig& config, const std::string& command) {
  if (NumScanners(config) < 2) return;
  throw InvalidConfig("the flight has " + std::to_string(NumScanners(config)) + " scanners (" +
                          JoinNames(ScannerNames(config)) + "), and " + command +
                          " takes one: add --scanner " + config.lidar->name,
                      FileLocation{config.file.string(), 0, 0});
}

double PairSigma(const FlightConfig& config, const LidarPair& pair) {
  const auto i = static_cast<std::size_t>(pair.scanner_i);
  const auto j = static_cast<std::size_t>(pair.scanner_j);
  for (const PairsBetween& between : config.pairs_between) {
    const bool same = (between.scanner_i == i && between.scanner_j == j) ||
                      (between.scanner_i == j && between.scanner_j == i);
    if (same) return between.sigma_p_m;
  }
  return ScannerAt(config, i).sigma_p_m;
}

}  // namespace dn
