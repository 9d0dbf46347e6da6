#pragma once

#include <Eigen/Core>

namespace dn {

/// Downward ray in the frame m.
struct LaserRay {
  LaserRay(const Eigen::Vector3d& origin, const Eigen::Vector3d& unit_direction)
      : origin_m(origin),
        direction(unit_direction),
        across(unit_direction.head<2>().norm()),
        heading(across > 0.0 ? Eigen::Vector2d(unit_direction.head<2>() / across)
                             : Eigen::Vector2d(1.0, 0.0)) {}

  Eigen::Vector3d At(double range_m) const { return origin_m + range_m * direction; }
  double Height(double range_m) const { return origin_m.z() + range_m * direction.z(); }
  Eigen::Vector2d Place(double range_m) const {
    return origin_m.head<2>() + range_m * direction.head<2>();
  }
  double RangeAtHeight(double height_m) const { return (height_m - origin_m.z()) / direction.z(); }
  /// Returns the horizontal distance of a place from the vertical plane of the ray.
  double Aside(const Eigen::Vector2d& en_m) const {
    const Eigen::Vector2d d = en_m - origin_m.head<2>();
    return heading.x() * d.y() - heading.y() * d.x();
  }

  Eigen::Vector3d origin_m;
  Eigen::Vector3d direction;
  double across;            ///< horizontal part of the direction
  Eigen::Vector2d heading;  ///< unit vector along it
};

}  // namespace dn
