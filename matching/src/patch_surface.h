#pragma once

#include <dn/matching/point_cloud.h>

#include <Eigen/Core>
#include <vector>

#include "point_tree.h"

namespace dn::matching_internal {

/// Points of a strip around a place, each with the plane of its neighbourhood.
class PatchSurface {
 public:
  /// radius_m: radius of the neighbourhoods. Needs at least one point.
  PatchSurface(std::vector<Eigen::Vector3d> points_m, double radius_m);

  const std::vector<Eigen::Vector3d>& points_m() const { return points_m_; }
  const LocalPlane& plane(std::size_t i) const { return planes_[i]; }

  /// Returns the point nearest to p_m and its distance.
  PointTree::Nearest NearestTo(const Eigen::Vector3d& p_m) const { return tree_.NearestTo(p_m); }

 private:
  std::vector<Eigen::Vector3d> points_m_;
  PointTree tree_;
  std::vector<LocalPlane> planes_;
};

}  // namespace dn::matching_internal
