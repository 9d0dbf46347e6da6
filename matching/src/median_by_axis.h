#pragma once

#include <dn/median.h>

#include <Eigen/Core>
#include <utility>
#include <vector>

namespace dn::matching_internal {

/// Returns the median of each coordinate; `values` must not be empty.
inline Eigen::Vector3d MedianByAxis(const std::vector<Eigen::Vector3d>& values) {
  Eigen::Vector3d median;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> of_axis;
    for (const Eigen::Vector3d& value : values) of_axis.push_back(value[axis]);
    median[axis] = Median(std::move(of_axis));
  }
  return median;
}

}  // namespace dn::matching_internal
