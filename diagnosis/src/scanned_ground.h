#pragma once

#include <dn/flight/flight.h>
#include <dn/sim/scenario.h>

namespace dn {

/// Pattern and field of view of a scanner, from the scan angles of the flight's pairs, in a
/// scenario with its mounting.
LidarScenario ScannerOf(const Flight& flight, const Mounting& mounting);

/// Ground of the height and roughness of the georeferenced pairs, which every strip clears.
TerrainScenario GroundOf(const Flight& flight, const Trajectory& trajectory,
                         const Mounting& mounting, const std::vector<StripInterval>& strips);

}  // namespace dn
