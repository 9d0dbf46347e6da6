#pragma once

#include <Eigen/Core>

namespace dn::testing {

/// Returns the value of a block of one number.
inline Eigen::Matrix<double, 1, 1> OneByOne(double x) { return Eigen::Matrix<double, 1, 1>(x); }

}  // namespace dn::testing
