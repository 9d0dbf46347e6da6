#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace dn::apps {

/// Number of positions of each quality that a file of NMEA sentences states.
using NmeaQualities = std::map<int, long>;

/// Counts the qualities. Returns nothing for a file that cannot be read.
NmeaQualities CountNmeaQualities(const std::filesystem::path& file);

/// Returns the line of flight.yaml with the sigmas that are usual for the most frequent quality.
std::string NmeaSigmaText(const NmeaQualities& qualities);

/// Returns the continuation of a sentence, which names the qualities if there are several.
std::string MixedQualitiesText(const NmeaQualities& qualities);

}  // namespace dn::apps
