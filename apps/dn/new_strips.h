#pragma once

#include <dn/files/georeference_strip.h>
#include <dn/geo/local_frame.h>
#include <dn/report/json.h>

#include <vector>

#include "command.h"

namespace dn::apps {

/// Input of a georeferencing of the strips of one scanner, except the points.
struct ScannerStrips {
  FlightConfig config;  ///< of this scanner alone
  GeoreferenceOptions options;
};

/// Input of a georeferencing of all strips of a flight, except the points.
struct NewStrips {
  FlightConfig config;  ///< of all scanners; names the trajectory of the new points
  std::vector<ScannerStrips> scanners;
  LocalFrame frame{Geodetic{}};
  Json covariance = nullptr;  ///< origin of the covariances, for georef.json
};

/// Returns the configuration of each scanner that has strips. Throws InvalidConfig if the flight
/// has no scanner or its points are in an unknown system, and InvalidInput if it has no strips.
std::vector<FlightConfig> GeoreferenceableScanners(const FlightConfig& config);

/// Returns the input of each of these scanners: what its configuration says of georeferencing, with
/// the trajectories and threads of `trajectories`.
std::vector<ScannerStrips> StatedStrips(const FlightConfig& config,
                                        GeoreferenceOptions trajectories);

/// Throws InvalidInput if corrections of the beams of a scanner could not be applied: the first
/// points of a strip have no laser vectors or no beams.
void ExpectBeamsInStrips(const FlightConfig& config);

/// Georeferences all strips of a flight and prints a table. Stages georef.json and the strips, in
/// folders with the names of the old ones. Stages swaths.json and swaths.geojson unless they are
/// staged already. Throws InvalidInput if a strip fails.
void GeoreferenceStrips(NewStrips work, Run& run);

}  // namespace dn::apps
