#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <vector>

namespace dn::matching_internal {

/// Search tree for the nearest points of a cloud. It uses FLANN directly, because PCL opens and
/// closes a team of OpenMP threads for every query, which takes longer than the query. Coordinates
/// are stored in single precision relative to the first point.
class PointTree {
 public:
  /// Needs at least one point.
  explicit PointTree(const std::vector<Eigen::Vector3d>& points_m);
  ~PointTree();
  PointTree(PointTree&&) noexcept;

  struct Nearest {
    std::size_t index = 0;
    double distance_m = 0.0;
  };
  Nearest NearestTo(const Eigen::Vector3d& p_m) const;

  /// Fills `found` with the points closer than radius_m in arbitrary order.
  void FindWithin(const Eigen::Vector3d& p_m, double radius_m,
                  std::vector<std::size_t>* found) const;

  /// Fills `found` with the points closest to p_m, at most `count`, all closer than radius_m.
  void FindNearest(const Eigen::Vector3d& p_m, std::size_t count, double radius_m,
                   std::vector<std::size_t>* found) const;

 private:
  struct Index;
  std::unique_ptr<const Index> index_;
};

}  // namespace dn::matching_internal
