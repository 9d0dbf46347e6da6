#pragma once

#include <dn/eigen_alignment.h>

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "point_tree.h"

namespace dn::matching_internal {

/// The distribution of the points nearest to a point.
struct Neighbourhood {
  enum class Kind : std::uint8_t { kSparse, kPlanar, kVolumetric };
  Kind kind = Kind::kSparse;
  Eigen::Vector3d mean_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< direction of the least variance
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
  double least_variance_m2 = 0.0;  ///< along the normal

  bool planar() const { return kind == Kind::kPlanar; }
};

/// Points of a strip around a place, each with its neighbourhood: the 16 nearest points within
/// reach_m. A neighbourhood is planar if its least variance is below 0.08 of the middle one.
class PatchSurface {
 public:
  /// Needs at least one point.
  PatchSurface(std::vector<Eigen::Vector3d> points_m, double reach_m);

  const std::vector<Eigen::Vector3d>& points_m() const { return points_m_; }
  const Neighbourhood& neighbourhood(std::size_t i) const { return neighbourhoods_[i]; }

  /// Returns the point nearest to p_m and its distance.
  PointTree::Nearest NearestTo(const Eigen::Vector3d& p_m) const { return tree_.NearestTo(p_m); }

 private:
  std::vector<Eigen::Vector3d> points_m_;
  PointTree tree_;
  std::vector<Neighbourhood> neighbourhoods_;
};

}  // namespace dn::matching_internal
