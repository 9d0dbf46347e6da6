#pragma once

#include <optional>
#include <string>

namespace dn::geo_internal {

struct UtmZone {
  int zone;
  bool south;
};

/// A name of PointCrs in its parts.
struct CrsName {
  std::string system;          ///< without the unit of the heights
  double height_unit_m = 1.0;  ///< metres per unit
};

/// Splits a name. The system of an unknown unit is the whole name.
CrsName SplitCrsName(const std::string& name);

std::optional<UtmZone> ParseUtm(const std::string& system);

/// Returns what PROJ takes for epsg: and wkt:; nullopt for other systems.
std::optional<std::string> ProjDefinition(const std::string& system);

}  // namespace dn::geo_internal
