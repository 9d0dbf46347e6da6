#pragma once

#include <dn/files/georeference_strip.h>
#include <dn/geo/local_frame.h>
#include <dn/report/json.h>

#include "command.h"

namespace dn::apps {

/// Input of a georeferencing of all strips of a flight, except the points.
struct NewStrips {
  FlightConfig config;  ///< names the trajectory of the new points
  LocalFrame frame{Geodetic{}};
  GeoreferenceOptions options;
  Json covariance = nullptr;  ///< origin of the covariances, for georef.json
};

/// Returns what the configuration says of georeferencing; the trajectories are left out.
GeoreferenceOptions StatedGeoreferencing(const FlightConfig& config, int threads);

/// Throws InvalidConfig if the flight has no scanner or its points are in an unknown system.
void ExpectGeoreferenceable(const FlightConfig& config);

/// Throws InvalidInput if the corrections of beams could not be applied: the scanner has several
/// beams, but the first points of a strip have no laser vectors or no beams.
void ExpectBeamsInStrips(const FlightConfig& config);

/// Georeferences all strips of a flight, stages strips/ and georef.json, and prints a table. Stages
/// swaths.json and swaths.geojson unless they are staged already. Throws InvalidInput if a strip
/// fails.
void GeoreferenceStrips(NewStrips work, Run& run);

}  // namespace dn::apps
