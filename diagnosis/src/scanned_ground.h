#pragma once

#include <dn/files/flight.h>
#include <dn/sim/scenario.h>

namespace dn {

/// Returns a scanner with the given mounting. Its pattern and field of view are estimated from the
/// scan angles of the flight's pairs.
LidarScenario EstimateScanner(const Flight& flight, const Mounting& mounting);

/// Returns ground with the height and roughness of the georeferenced pairs, below every strip.
TerrainScenario EstimateGround(const Flight& flight, const Trajectory& trajectory,
                               const Mounting& mounting, const std::vector<StripInterval>& strips);

}  // namespace dn
