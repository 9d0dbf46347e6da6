#pragma once

#include <dn/report/document.h>

#include <string>
#include <vector>

#include "result_folder.h"

namespace dn::internal {

/// The strips of swaths.json with the paths of the body over them; without contents where the folder
/// has none.
MapChart SwathMap(const ResultFolder& folder, const std::string& title);

/// Pairs on the ground, and how far their points are apart.
struct PlacedPairs {
  std::vector<double> east_m, north_m;
  std::vector<double> before_m, after_m;

  void Add(double east, double north, double before, double after);
};

/// Two maps of the pairs over the strips in the same colours, before and after; none without pairs.
std::vector<MapChart> MapsOf(const ResultFolder& folder, const PlacedPairs& pairs);

}  // namespace dn::internal
