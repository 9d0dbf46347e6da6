#pragma once

#include <dn/files/flight_config.h>
#include <dn/lidar/pairs.h>

namespace dn::files_internal {

/// Checks the beams of pairs against `beams` of their scanners. Throws InvalidInput with the pair
/// if a beam does not exist. Throws InvalidConfig if no pair of a scanner with beams has one. Also
/// throws if the laser vectors of a beam are on average more than 1 deg and more than ten sigmas
/// away from its angle.
void CheckPairBeams(const FlightConfig& config, const PairData& data);

}  // namespace dn::files_internal
