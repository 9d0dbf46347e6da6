#include "patch_surface.h"

#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>

#include <cmath>
#include <numeric>
#include <utility>

namespace dn::internal {

using Eigen::Vector3d;

/// PCL holds coordinates in single precision: they count from the first point.
struct PatchSurface::Tree {
  explicit Tree(const std::vector<Vector3d>& points_m)
      : origin_m(points_m.front()), cloud(pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>()) {
    cloud->reserve(points_m.size());
    for (const Vector3d& p_m : points_m) cloud->push_back(Local(p_m));
    search.setInputCloud(cloud);
  }

  pcl::PointXYZ Local(const Vector3d& p_m) const {
    const Eigen::Vector3f p = (p_m - origin_m).cast<float>();
    return {p.x(), p.y(), p.z()};
  }

  Vector3d origin_m;
  pcl::PointCloud<pcl::PointXYZ>::Ptr cloud;
  pcl::search::KdTree<pcl::PointXYZ> search;
};

PatchSurface::PatchSurface(std::vector<Vector3d> points_m, double radius_m)
    : points_m_(std::move(points_m)), tree_(std::make_unique<Tree>(points_m_)) {
  std::vector<std::size_t> all(points_m_.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  planes_ = FitLocalPlanes(points_m_, all, radius_m);
}

PatchSurface::~PatchSurface() = default;
PatchSurface::PatchSurface(PatchSurface&&) noexcept = default;

PatchSurface::Nearest PatchSurface::NearestTo(const Vector3d& p_m) const {
  pcl::Indices index(1);
  std::vector<float> squared_m2(1);
  tree_->search.nearestKSearch(tree_->Local(p_m), 1, index, squared_m2);
  return {static_cast<std::size_t>(index[0]), std::sqrt(static_cast<double>(squared_m2[0]))};
}

}  // namespace dn::internal
