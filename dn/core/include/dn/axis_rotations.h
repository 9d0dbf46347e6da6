#pragma once

#include <dn/eigen_alignment.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

namespace dn {

/// Returns the 24 rotations with positive or negative unit vectors as columns, the identity first.
/// They are the possible orientations of an instrument with axes parallel to those of the body.
inline std::vector<Eigen::Matrix3d> AxisRotations() {
  using Eigen::Vector3d;
  std::vector<Eigen::Matrix3d> rotations;
  for (int x = 0; x < 6; ++x) {
    for (int y = 0; y < 6; ++y) {
      if (x % 3 == y % 3) continue;
      Eigen::Matrix3d R;
      R.row(0) = (x < 3 ? 1.0 : -1.0) * Vector3d::Unit(x % 3);
      R.row(1) = (y < 3 ? 1.0 : -1.0) * Vector3d::Unit(y % 3);
      R.row(2) = Vector3d(R.row(0)).cross(Vector3d(R.row(1)));
      rotations.push_back(R);
    }
  }
  return rotations;
}

}  // namespace dn
