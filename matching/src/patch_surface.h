#pragma once

#include <dn/matching/point_cloud.h>

#include <Eigen/Core>
#include <memory>
#include <vector>

namespace dn::internal {

/// Points of one strip around a place, each with the plane of its neighbourhood.
class PatchSurface {
 public:
  /// radius_m: of the neighbourhoods. At least one point.
  PatchSurface(std::vector<Eigen::Vector3d> points_m, double radius_m);
  ~PatchSurface();
  PatchSurface(PatchSurface&&) noexcept;

  const std::vector<Eigen::Vector3d>& points_m() const { return points_m_; }
  const LocalPlane& plane(std::size_t i) const { return planes_[i]; }

  /// The point nearest to p_m, and its distance.
  struct Nearest {
    std::size_t index = 0;
    double distance_m = 0.0;
  };
  Nearest NearestTo(const Eigen::Vector3d& p_m) const;

 private:
  struct Tree;
  std::vector<Eigen::Vector3d> points_m_;
  std::vector<LocalPlane> planes_;
  std::unique_ptr<Tree> tree_;
};

}  // namespace dn::internal
