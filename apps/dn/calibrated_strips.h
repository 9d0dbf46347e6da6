#pragma once

#include <dn/adjustment/result.h>
#include <dn/diagnosis/beams_output.h>
#include <dn/files/flight.h>

#include <map>
#include <string>
#include <vector>

#include "command.h"

namespace dn::apps {

/// Boresights by the name of their scanner; that of a flight without a list has no name.
using BoresightByScanner = std::map<std::string, const BoresightResult*>;

/// Stages the strips of the flight with the boresights of its scanners, unless one of them is not
/// reliable. A scanner without an estimate keeps its stated boresight. `adjusted`: the trajectory
/// of the network; null: that of the flight.
void AddNewStrips(const FlightConfig& config, const BoresightByScanner& boresights,
                  const std::vector<BeamCorrections>& beams, const Trajectory* adjusted, Run* run);

}  // namespace dn::apps
