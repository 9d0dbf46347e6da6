#pragma once

#include <dn/report/document.h>

#include <string>
#include <vector>

#include "result_folder.h"

namespace dn::page_internal {

/// Returns a map of the strips of swaths.json and the paths of the body. It has no contents if the
/// folder has no swaths.json.
MapChart SwathMap(const ResultFolder& folder, const std::string& title);

/// Pairs on the ground, with the distance between their points before and after, m.
struct PlacedPairs {
  std::vector<double> east_m, north_m;
  std::vector<double> before_m, after_m;

  void Add(double east, double north, double before, double after);
};

/// Returns two maps of the pairs over the strips with the same colours, before and after; none
/// without pairs.
std::vector<MapChart> PairMaps(const ResultFolder& folder, const PlacedPairs& pairs);

}  // namespace dn::page_internal
