#include <dn/error.h>
#include <dn/matching/point_cloud.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "checks.h"
#include "point_tree.h"

namespace dn {
namespace {

/// Neighbours lie on a line if the second eigenvalue is a rounding error relative to the first.
constexpr double kLineRatio = 1e-12;

LocalPlane FitPlane(const std::vector<Eigen::Vector3d>& points_m,
                    const std::vector<std::size_t>& neighbours) {
  LocalPlane plane;
  plane.neighbours = neighbours.size();
  const double n = static_cast<double>(neighbours.size());
  const Eigen::Vector3d& base_m = points_m[neighbours.front()];
  Eigen::Vector3d mean_m = Eigen::Vector3d::Zero();
  for (const std::size_t i : neighbours) mean_m += points_m[i] - base_m;
  mean_m /= n;
  plane.centroid_m = base_m + mean_m;

  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
  for (const std::size_t i : neighbours) {
    const Eigen::Vector3d d_m = points_m[i] - plane.centroid_m;
    covariance_m2 += d_m * d_m.transpose() / n;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(covariance_m2);
  const Eigen::Vector3d& l = eigen.eigenvalues();  // ascending
  if (neighbours.size() < 3 || !(l[1] > kLineRatio * l[2])) return plane;

  plane.normal = eigen.eigenvectors().col(0);
  if (plane.normal.z() < 0.0) plane.normal = -plane.normal;
  plane.rms_m = std::sqrt(std::max(0.0, l[0]));
  plane.planarity = (l[1] - std::max(0.0, l[0])) / l[2];
  return plane;
}

}  // namespace

std::vector<LocalPlane> FitLocalPlanes(const std::vector<Eigen::Vector3d>& points_m,
                                       const std::vector<std::size_t>& at, double radius_m) {
  matching_internal::CheckPositive("radius", radius_m);
  matching_internal::CheckPoints(points_m, std::numeric_limits<double>::max());
  for (const std::size_t i : at) {
    if (i < points_m.size()) continue;
    throw InvalidInput("index " + std::to_string(i) + " is out of range: there are " +
                       std::to_string(points_m.size()) + " points");
  }
  if (at.empty()) return {};
  const matching_internal::PointTree tree(points_m);
  std::vector<LocalPlane> planes;
  std::vector<std::size_t> neighbours;
  planes.reserve(at.size());
  for (const std::size_t i : at) {
    tree.FindWithin(points_m[i], radius_m, &neighbours);
    planes.push_back(FitPlane(points_m, neighbours));
  }
  return planes;
}

}  // namespace dn
