#pragma once

#include <dn/matching/match.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "match_flight.h"

namespace dn::apps {

/// Strips of several scanners, which may be those of several flights: the matches of each scanner,
/// and those of every two with each other.
struct JointMatches {
  std::vector<MatchedFlight> each;  ///< the scanners alone
  std::unique_ptr<ScannersMatchSource> source;
  MatchResult result;  ///< of all; the strips are those of `source`

  /// Name of the scanner of a strip, and of the strip among those of its scanner.
  const std::string& ScannerName(std::size_t strip) const;
  const std::string& StripName(std::size_t strip) const;
};

/// Matches the strips of each scanner, which aligns it, and then those of every two. Scanners
/// whose own strips do not overlap are aligned together with the others. Covariances contain what
/// the loops of strips imply (InflateLoops).
JointMatches MatchJointly(std::vector<MatchedFlight> each, const std::vector<std::string>& names,
                          const MatchOptions& options);

/// Stages the pair files, with the names that `pair_file` gives them, and the files of
/// AddMatchFiles. match.json has name, ground sampling distance and boresight of each scanner under
/// the key `each`. `name`: that of the flight or flights.
void AddJointMatches(const JointMatches& matches, const std::string& name, const std::string& each,
                     const std::function<std::string(const StripPairMatch&)>& pair_file, Run& run);

}  // namespace dn::apps
