#pragma once

#include <dn/report/document.h>

#include <string>
#include <vector>

#include "result_folder.h"

namespace dn::page_internal {

/// Returns a map of the strips of swaths.json and the paths of the body. It has no contents if the
/// folder has no swaths.json.
MapChart SwathMap(const ResultFolder& folder, const std::string& title);

/// Places on the ground, with a distance before and after, m.
struct PlacedDistances {
  std::vector<double> east_m, north_m;
  std::vector<double> before_m, after_m;

  void Add(double east, double north, double before, double after);
};

/// Returns two maps of the places over the strips with the same colours, before and after; none
/// without places. The titles are `title` with ", before" and ", after".
std::vector<MapChart> DistanceMaps(const ResultFolder& folder, const std::string& title,
                                   const PlacedDistances& distances);

}  // namespace dn::page_internal
