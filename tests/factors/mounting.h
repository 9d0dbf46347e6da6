#pragma once

#include <Eigen/Core>

namespace dn::testing {

inline Eigen::Matrix3d Mounting() {
  return Eigen::Matrix3d{{0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}, {1.0, 0.0, 0.0}};
}

}  // namespace dn::testing
