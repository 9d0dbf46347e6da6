#pragma once

#include <dn/geo/local_frame.h>

#include <optional>
#include <string>

namespace dn {

/// What the columns of a text trajectory are, after the time; by default those of ODyN.
struct TrajectoryColumns {
  enum class Attitude {
    kQuaternionNed,     ///< w, x, y, z, body -> local north-east-down
    kQuaternionEnu,     ///< w, x, y, z, body -> local east-north-up
    kRollPitchHeading,  ///< deg, R_nb = Rz(heading) Ry(pitch) Rx(roll), body FRD, heading from north
    kRollPitchYawEnu,   ///< deg, R_enu_b = Rz(yaw) Ry(pitch) Rx(roll), body FLU, yaw from east
  };

  /// geographic: latitude, longitude [deg], ellipsoidal height [m]; else what PointCrs takes: map,
  /// utm:32n, ecef [m].
  std::string crs = "geographic";
  Attitude attitude = Attitude::kQuaternionNed;
  /// The horizontal axes of the attitude are those of the UTM grid, not true north and east.
  bool grid_north = false;
  bool body_is_flu = false;                 ///< of quaternions
  std::optional<Geodetic> map_origin = {};  ///< of crs map

  bool has_quaternion() const {
    return attitude == Attitude::kQuaternionNed || attitude == Attitude::kQuaternionEnu;
  }
};

}  // namespace dn
