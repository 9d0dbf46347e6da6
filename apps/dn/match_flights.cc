#include "match_flights.h"

#include <dn/error.h>
#include <dn/files/scanners.h>
#include <fmt/format.h>

#include <utility>

#include "flight_pairs.h"
#include "match_jointly.h"
#include "output_folder.h"

namespace dn::apps {
namespace {

std::string PairFile(const JointMatches& matches, const StripPairMatch& match) {
  return fmt::format("{}/{}_{}.txt",
                     BetweenFolder(matches.ScannerName(match.i), matches.ScannerName(match.j)),
                     matches.StripName(match.i), matches.StripName(match.j));
}

void ExpectOwnName(const std::string& name, const std::vector<std::string>& names) {
  for (const std::string& other : names) {
    if (FolderName(other) != FolderName(name)) continue;
    throw InvalidConfig("two flights have the name " + name +
                        ": give each its own (key `name` of flight.yaml)");
  }
}

MatchedFlight OpenFlight(FlightConfig config, const PointFilter& filter, Run& run) {
  ExpectMatchable(config);
  ExpectOneScanner(config, "matching between flights");
  FlightPath path = FindFlightPath(&config, "", run);
  return OpenStrips(std::move(config), path, filter, run);
}

/// Keeps the pairs between flights only.
void KeepBetween(JointMatches* matches) {
  std::erase_if(matches->result.strip_pairs, [&](const StripPairMatch& match) {
    return matches->source->ScannerIndex(match.i) == matches->source->ScannerIndex(match.j);
  });
}

}  // namespace

void MatchFlights(const std::vector<std::string>& flights, const std::vector<std::string>& changes,
                  const MatchOptions& options, const PointFilter& filter, Run& run) {
  run.ReadsStrips();
  std::vector<MatchedFlight> each;
  std::vector<std::string> names;
  for (const std::string& flight : flights) {
    FlightConfig config = ReadFlightConfig(flight, changes);
    ExpectOwnName(config.name, names);
    names.push_back(config.name);
    each.push_back(OpenFlight(std::move(config), filter, run));
  }
  JointMatches matches = MatchJointly(std::move(each), names, options);
  KeepBetween(&matches);
  AddJointMatches(
      matches, fmt::format("{}", fmt::join(names, ", ")), "flights",
      [&](const StripPairMatch& match) { return PairFile(matches, match); }, run);
  if (matches.result.pairs() == 0) FailNoPairs();
}

}  // namespace dn::apps
