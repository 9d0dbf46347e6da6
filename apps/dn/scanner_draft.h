#pragma once

#include <string>
#include <vector>

#include "strip_scanner.h"

namespace dn::apps {

/// Returns the keys of a mounting by the axes of the laser vectors, each line after `indent`.
std::string MountingText(const ScannerAxes& axes, const std::string& indent);

/// Returns the section `lidar` of scanners that are known by their strips alone: one, or a list of
/// those with a name. `georeferencing`: its lines about the points of the strips.
std::string ScannersText(const std::vector<StripScanner>& scanners,
                         const std::string& georeferencing);

/// Adds a line for each scanner whose mounting or lever arm the strips do not show.
void AddMissingMountings(const std::vector<StripScanner>& scanners,
                         std::vector<std::string>* missing);

}  // namespace dn::apps
