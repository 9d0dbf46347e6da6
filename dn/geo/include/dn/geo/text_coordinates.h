#pragma once

#include <dn/error.h>
#include <dn/geo/local_frame.h>
#include <dn/geo/point_crs.h>

#include <optional>
#include <string>

namespace dn {

/// The positions of a text file: three columns in one coordinate system on WGS84,
///
///   geographic  latitude, longitude [deg], ellipsoidal height [m]
///   map         east, north, up [m] from an origin
///   utm:32n     grid east, grid north, ellipsoidal height [m]
///   ecef        geocentric x, y, z [m]
class TextCoordinates {
 public:
  /// Geographic.
  TextCoordinates() : TextCoordinates("geographic", std::nullopt, "crs") {}

  /// `key` names the system in messages, as "trajectory.crs". Throws InvalidConfig for another name,
  /// or a map without its origin.
  TextCoordinates(const std::string& crs, const std::optional<Geodetic>& map_origin,
                  std::string key);

  /// Throws InvalidInput for coordinates that are none of the system.
  Geodetic Read(const double* columns, const FileLocation& where) const;

  /// True azimuth of grid north at a point, rad; of UTM only.
  double Convergence_rad(const Geodetic& point) const;

  /// Whether a name is one of the four.
  static bool IsName(const std::string& crs);

 private:
  std::string key_;
  LocalFrame frame_;
  std::optional<PointCrs> crs_;
  bool utm_ = false;
};

}  // namespace dn
