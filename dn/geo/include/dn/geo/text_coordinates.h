#pragma once

#include <dn/error.h>
#include <dn/geo/local_frame.h>
#include <dn/geo/point_crs.h>

#include <optional>
#include <string>

namespace dn {

/// Converts the positions of a text file: three columns in one coordinate system on WGS84,
///
///   geographic  latitude, longitude [deg], ellipsoidal height [m]
///   map         east, north, up [m] from an origin
///   utm:32n     grid east, grid north, ellipsoidal height [m]
///   ecef        geocentric x, y, z [m]
class TextCoordinates {
 public:
  /// Creates the geographic system.
  TextCoordinates() : TextCoordinates("geographic", std::nullopt, "crs") {}

  /// Creates the named system. `key` is its key in messages, such as "trajectory.crs". Throws
  /// InvalidConfig for another name, or for a map without its origin.
  TextCoordinates(const std::string& crs, const std::optional<Geodetic>& map_origin,
                  std::string key);

  /// Converts three columns. Throws InvalidInput for coordinates outside of the system.
  Geodetic Read(const double* columns, const FileLocation& where) const;

  /// Returns the true azimuth of grid north at a point, rad; only valid for UTM.
  double Convergence_rad(const Geodetic& point) const;

  /// Returns true if the name is one of the four.
  static bool IsName(const std::string& crs);

 private:
  std::string key_;
  LocalFrame frame_;
  std::optional<PointCrs> crs_;
  bool utm_ = false;
};

}  // namespace dn
