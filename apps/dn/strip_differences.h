#pragma once

#include <dn/geo/point_crs.h>
#include <dn/lidar/strip_surface.h>
#include <dn/report/json.h>

#include <string>
#include <vector>

#include "command.h"

namespace dn::apps {

/// Flat ground of a strip, from its points as they were and as they are now.
struct StripSurfaces {
  std::string strip;
  FlatSurface before, after;
};

/// Compares all pairs of strips that have at least ten cells in common. Prints a table and returns
/// the list for georef.json. Writes the differences after the correction as rasters
/// differences/A-B.asc: second minus first, m, in the system of the points, which
/// differences/A-B.prj states. Returns an empty list if no strips overlap.
Json CompareStrips(const std::vector<StripSurfaces>& strips, const PointCrs& crs, Run* run);

}  // namespace dn::apps
