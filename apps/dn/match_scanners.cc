#include "match_scanners.h"

#include <dn/files/flight.h>

#include <algorithm>
#include <utility>

#include "given_trajectory.h"

namespace dn::apps {
namespace {

namespace fs = std::filesystem;

std::string PairFile(const MatchedScanners& matched, const StripPairMatch& match) {
  const std::string &a = matched.ScannerName(match.i), &b = matched.ScannerName(match.j);
  return "lidar_" + a + (a == b ? "" : "_" + b) + "/" + matched.StripName(match.i) + "_" +
         matched.StripName(match.j) + ".txt";
}

/// Returns the entry of two scanners, which is appended if there is none.
PairsBetween& Between(std::size_t i, std::size_t j, FlightConfig* config) {
  for (PairsBetween& entry : config->pairs_between) {
    if (entry.scanner_i == i && entry.scanner_j == j) return entry;
  }
  config->pairs_between.push_back(
      {i, j, {}, SigmaBetween(ScannerAt(*config, i), ScannerAt(*config, j))});
  return config->pairs_between.back();
}

}  // namespace

MatchedScanners MatchScannerStrips(FlightConfig config, const std::string& trajectory,
                                   const MatchOptions& options, const PointFilter& filter,
                                   Run& run) {
  ExpectMatchable(config);
  run.ReadsStrips();
  FlightPath path = FindFlightPath(&config, trajectory, run);
  std::vector<MatchedFlight> each;
  std::vector<std::string> names;
  for (std::size_t k = 0; k < NumScanners(config); ++k) {
    FlightConfig one = config;
    KeepScanner(k, &one);
    each.push_back(OpenStrips(std::move(one), path, filter, run));
    names.push_back(ScannerAt(config, k).name);
  }
  return {MatchJointly(std::move(each), names, options), std::move(config),
          std::move(path.smoothed)};
}

void AddMatches(const MatchedScanners& matched, Run& run) {
  AddJointMatches(
      matched, matched.config.name, "scanners",
      [&](const StripPairMatch& match) { return PairFile(matched, match); }, run);
}

FlightConfig WithMatches(const MatchedScanners& matched, const fs::path& folder,
                         const std::string& trajectory) {
  FlightConfig config = matched.config;
  const fs::path absolute = fs::absolute(folder);
  config.pairs_between.clear();
  for (std::size_t k = 0; k < NumScanners(config); ++k) ScannerAt(config, k).p2p.clear();
  for (const StripPairMatch& match : matched.result.strip_pairs) {
    if (match.pairs.empty()) continue;
    const std::size_t i = matched.source->ScannerIndex(match.i);
    const std::size_t j = matched.source->ScannerIndex(match.j);
    std::vector<std::string>& files =
        i == j ? ScannerAt(config, i).p2p : Between(i, j, &config).p2p;
    files.push_back((absolute / PairFile(matched, match)).string());
  }
  double shared_m = 0.0;
  for (const MatchedFlight& one : matched.each) {
    shared_m = std::max(shared_m, SharedRangeSigma(one.result));
  }
  AddRangeOffset(shared_m, &config);
  return matched.smoothed ? WithTrajectory(config, (absolute / trajectory).string()) : config;
}

}  // namespace dn::apps
