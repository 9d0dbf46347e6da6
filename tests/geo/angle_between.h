#pragma once

#include <dn/rotation.h>

#include <Eigen/Geometry>

namespace dn::testing {

/// Returns the angle of the rotation from a to b, rad.
inline double AngleRad(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return Log(Eigen::Quaterniond(a.conjugate() * b)).norm();
}

}  // namespace dn::testing
