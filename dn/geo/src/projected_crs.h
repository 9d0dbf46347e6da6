#pragma once

#include <dn/geo/local_frame.h>

#include <Eigen/Core>
#include <optional>
#include <string>

namespace dn::geo_internal {

/// A coordinate system of the EPSG register or of well-known text, by PROJ. Copies share nothing
/// but the definition; every method is thread-safe.
class ProjectedCrs {
 public:
  /// `definition` is a code ("EPSG:2056", "EPSG:25832+7837") or well-known text (WKT 1, WKT 2,
  /// ESRI). Throws InvalidConfig if PROJ does not know it, or if it is not a projected system. Also
  /// throws if it has no transformation to WGS84 that is better than a guess. Also throws if a
  /// better one needs a grid that is not installed (the message names it).
  explicit ProjectedCrs(std::string definition);

  /// Returns WGS84 coordinates of a point, and back; nullopt outside of the system. A point has
  /// easting, northing and height in the units of the system.
  std::optional<Geodetic> ToGeodetic(const Eigen::Vector3d& p_c) const;
  std::optional<Eigen::Vector3d> FromGeodetic(const Geodetic& point) const;

 private:
  std::string definition_;
};

/// A system that a file states, by PROJ.
struct StatedSystem {
  bool geocentric = false;
  bool compound = false;                  ///< with a vertical system of its own
  std::optional<std::string> horizontal;  ///< EPSG code of the horizontal part, if it has one
  std::optional<std::string> vertical;    ///< EPSG code of the vertical part, if it has one
  std::string horizontal_text;            ///< well-known text of the horizontal part
  double horizontal_unit_m = 1.0;         ///< metres per unit of the coordinates
  double height_unit_m = 1.0;             ///< metres per unit of the heights
};

/// Reads a definition; nullopt if PROJ does not know it or if it is a geographic system.
std::optional<StatedSystem> ReadSystem(const std::string& definition);

/// Returns well-known text of the horizontal part in the form of Esri; nullopt if PROJ does not
/// know the system or cannot state it so.
std::optional<std::string> HorizontalEsriText(const std::string& definition);

/// Returns true if both definitions mean the same system, apart from names and the order of axes.
bool AreSameSystem(const std::string& a, const std::string& b);

}  // namespace dn::geo_internal
