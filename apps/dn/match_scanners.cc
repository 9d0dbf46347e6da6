#include "match_scanners.h"

#include <dn/files/flight.h>
#include <dn/matching/loop_redundancy.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "given_trajectory.h"
#include "swath_files.h"

namespace dn::apps {
namespace {

namespace fs = std::filesystem;

/// Returns the options for matches between scanners: the coarser ground sampling distance. Beams
/// are kept apart if all scanners have as many.
MatchOptions OptionsBetween(MatchOptions options, const std::vector<MatchedFlight>& each) {
  const auto beams_of = [](const MatchedFlight& one) {
    return one.config.lidar->beams ? static_cast<int>(one.config.lidar->beams->count) : 1;
  };
  options.beams = beams_of(each.front());
  double gsd_m = 0.0;
  for (const MatchedFlight& one : each) {
    if (beams_of(one) != options.beams) options.beams = 1;
    gsd_m = std::max(gsd_m, one.result.gsd_m);
  }
  options.gsd_m = gsd_m / std::sqrt(options.beams);
  return options;
}

/// Adds the matches of one scanner, whose strips begin at `first`, to those of all.
void AddOwn(const MatchResult& own, std::size_t first, MatchResult* all) {
  for (StripPairMatch match : own.strip_pairs) {
    match.i += first;
    match.j += first;
    all->strip_pairs.push_back(std::move(match));
  }
  std::copy(own.levels.begin(), own.levels.end(), std::back_inserter(all->levels));
}

std::string PairFile(const MatchedScanners& matched, const StripPairMatch& match) {
  const ScannersMatchSource& source = *matched.source;
  const std::string a = matched.Scanner(match.i).name, b = matched.Scanner(match.j).name;
  const auto strip = [&](std::size_t k) {
    return source.scanners()[source.ScannerIndex(k)].source->strips()[source.StripIndex(k)].name;
  };
  return "lidar_" + a + (a == b ? "" : "_" + b) + "/" + strip(match.i) + "_" + strip(match.j) +
         ".txt";
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

Json ScannersJson(const MatchedScanners& matched) {
  Json scanners = Json::array();
  for (std::size_t k = 0; k < matched.each.size(); ++k) {
    const MatchResult& result = matched.each[k].result;
    scanners.push_back({{"name", ScannerAt(matched.config, k).name},
                        {"gsd_m", result.gsd_m},
                        {"boresight_used_deg", dn::ToJson(result.boresight_rad * kDegPerRad)}});
  }
  return {{"scanners", scanners}};
}

}  // namespace

MatchedScanners MatchScannerStrips(FlightConfig config, const std::string& trajectory,
                                   const MatchOptions& options, const PointFilter& filter,
                                   Run& run) {
  ExpectMatchable(config);
  run.ReadsStrips();
  MatchedScanners matched;
  FlightPath path = FindFlightPath(&config, trajectory, run);
  std::vector<ScannersMatchSource::Scanner> scanners;
  for (std::size_t k = 0; k < NumScanners(config); ++k) {
    FlightConfig one = config;
    KeepScanner(k, &one);
    matched.each.push_back(OpenStrips(std::move(one), path, filter, run));
    MatchOpened(options, &matched.each.back());
    scanners.push_back({ScannerAt(config, k).name, matched.each.back().source.get()});
  }
  matched.source = std::make_unique<ScannersMatchSource>(std::move(scanners));
  matched.result = MatchScanners(matched.source.get(), OptionsBetween(options, matched.each));
  std::vector<StripPairMatch> between = std::exchange(matched.result.strip_pairs, {});
  std::size_t first = 0;
  for (const MatchedFlight& one : matched.each) {
    AddOwn(one.result, first, &matched.result);
    first += one.result.strips.size();
  }
  std::ranges::move(between, std::back_inserter(matched.result.strip_pairs));
  InflateLoops(&matched.result);
  matched.result.boresight_rad = matched.each.front().result.boresight_rad;
  matched.config = std::move(config);
  matched.smoothed = std::move(path.smoothed);
  return matched;
}

void AddMatches(const MatchedScanners& matched, Run& run) {
  for (const StripPairMatch& match : matched.result.strip_pairs) {
    AddPairFile(PairFile(matched, match), match, matched.result,
                {matched.Scanner(match.i).time_offset_s, matched.Scanner(match.j).time_offset_s},
                run);
  }
  AddMatchFiles(matched.config.name, matched.result, *matched.source, run, ScannersJson(matched));
  AddSwathFiles(matched.result.swaths, matched.each.front().source->frame(), &run);
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
