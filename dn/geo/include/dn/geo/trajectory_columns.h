#pragma once

#include <dn/geo/local_frame.h>
#include <dn/geo/named_columns.h>

#include <optional>
#include <string>
#include <vector>

namespace dn {

/// Meaning of the columns of a text trajectory after the time; the default is ODyN's.
struct TrajectoryColumns {
  enum class Attitude {
    kQuaternionNed,     ///< w, x, y, z, body -> local north-east-down
    kQuaternionEnu,     ///< w, x, y, z, body -> local east-north-up
    kRollPitchHeading,  ///< deg, R_nb = Rz(heading) Ry(pitch) Rx(roll), body FRD, from north
    kRollPitchYawEnu,   ///< deg, R_enu_b = Rz(yaw) Ry(pitch) Rx(roll), body FLU, from east
  };

  /// Coordinate system of the positions: geographic (latitude, longitude [deg], ellipsoidal height
  /// [m]), or a name that PointCrs accepts (map, utm:32n, ecef [m]).
  std::string crs = "geographic";
  Attitude attitude = Attitude::kQuaternionNed;
  /// True if the horizontal axes of the attitude are those of the UTM grid instead of true north
  /// and east.
  bool grid_north = false;
  /// Names of the columns: t, lat, lon, h, then qw, qx, qy, qz or roll, pitch, heading; empty: in
  /// this order.
  ColumnNames names = {};
  bool body_is_flu = false;                 ///< only for quaternions
  std::optional<Geodetic> map_origin = {};  ///< only for crs map

  bool has_quaternion() const {
    return attitude == Attitude::kQuaternionNed || attitude == Attitude::kQuaternionEnu;
  }
};

/// Quantities of the columns of a text trajectory, for an attitude in quaternions or angles.
std::vector<std::string> TrajectoryQuantities(bool quaternions);

}  // namespace dn
