#include "match_jointly.h"

#include <dn/matching/loop_redundancy.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "swath_files.h"

namespace dn::apps {
namespace {

constexpr std::size_t kFewestAligning = 6;  // pairs that align a scanner

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

/// Returns name, ground sampling distance and boresight of each scanner.
Json EachJson(const JointMatches& matches) {
  Json each = Json::array();
  for (std::size_t k = 0; k < matches.each.size(); ++k) {
    const MatchResult& result = matches.each[k].result;
    each.push_back({{"name", matches.source->scanners()[k].name},
                    {"gsd_m", result.gsd_m},
                    {"boresight_used_deg", dn::ToJson(result.boresight_rad * kDegPerRad)}});
  }
  return each;
}

}  // namespace

const std::string& JointMatches::ScannerName(std::size_t strip) const {
  return source->scanners()[source->ScannerIndex(strip)].name;
}

const std::string& JointMatches::StripName(std::size_t strip) const {
  const FlightMatchSource& own = *source->scanners()[source->ScannerIndex(strip)].source;
  return own.strips()[source->StripIndex(strip)].name;
}

JointMatches MatchJointly(std::vector<MatchedFlight> each, const std::vector<std::string>& names,
                          const MatchOptions& options) {
  JointMatches matches;
  matches.each = std::move(each);
  MatchOptions own = options;
  own.must_overlap = false;
  std::vector<ScannersMatchSource::Scanner> scanners;
  for (std::size_t k = 0; k < matches.each.size(); ++k) {
    MatchOpened(own, &matches.each[k]);
    const bool aligned = matches.each[k].result.pairs() >= kFewestAligning;
    scanners.push_back({names[k], matches.each[k].source.get(), aligned});
  }
  matches.source = std::make_unique<ScannersMatchSource>(std::move(scanners));
  matches.result = MatchScanners(matches.source.get(), OptionsBetween(options, matches.each));
  for (MatchedFlight& one : matches.each) {
    one.result.boresight_rad = one.source->mounting().boresight_rad;
  }
  std::vector<StripPairMatch> between = std::exchange(matches.result.strip_pairs, {});
  std::size_t first = 0;
  for (const MatchedFlight& one : matches.each) {
    AddOwn(one.result, first, &matches.result);
    first += one.result.strips.size();
  }
  std::ranges::move(between, std::back_inserter(matches.result.strip_pairs));
  InflateLoops(&matches.result);
  matches.result.boresight_rad = matches.each.front().result.boresight_rad;
  return matches;
}

void AddJointMatches(const JointMatches& matches, const std::string& name, const std::string& each,
                     const std::function<std::string(const StripPairMatch&)>& pair_file, Run& run) {
  const auto offset_s = [&](std::size_t strip) {
    return matches.each[matches.source->ScannerIndex(strip)].config.lidar->time_offset_s;
  };
  for (const StripPairMatch& match : matches.result.strip_pairs) {
    AddPairFile(pair_file(match), match, matches.result, {offset_s(match.i), offset_s(match.j)},
                run);
  }
  Json more;
  more[each] = EachJson(matches);
  AddMatchFiles(name, matches.result, *matches.source, run, more);
  AddSwathFiles(matches.result.swaths, matches.each.front().source->frame(), &run);
}

}  // namespace dn::apps
