#include "patch_surface.h"

#include <Eigen/Eigenvalues>
#include <utility>

namespace dn::matching_internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::size_t kPlaneNeighbours = 16;
constexpr std::size_t kFewestNeighbours = 6;
constexpr double kPlanarRatio = 0.08;  // least variance over the middle one
constexpr double kLineRatio = 1e-12;   // second variance over the first: rounding errors

Neighbourhood Describe(const std::vector<Vector3d>& points_m,
                       const std::vector<std::size_t>& nearest) {
  Neighbourhood out;
  if (nearest.size() < kFewestNeighbours) return out;
  const double n = static_cast<double>(nearest.size());
  const Vector3d& base_m = points_m[nearest.front()];
  Vector3d mean_m = Vector3d::Zero();
  Matrix3d squares_m2 = Matrix3d::Zero();
  for (const std::size_t i : nearest) {
    const Vector3d d_m = points_m[i] - base_m;
    mean_m += d_m / n;
    squares_m2 += d_m * d_m.transpose() / n;
  }
  out.mean_m = base_m + mean_m;
  out.covariance_m2 = squares_m2 - mean_m * mean_m.transpose();
  Eigen::SelfAdjointEigenSolver<Matrix3d> eigen;
  eigen.computeDirect(out.covariance_m2);
  const Vector3d& variances_m2 = eigen.eigenvalues();  // ascending
  if (!(variances_m2[1] > kLineRatio * variances_m2[2])) return out;
  out.normal = eigen.eigenvectors().col(0);
  out.least_variance_m2 = out.normal.dot(out.covariance_m2 * out.normal);
  out.kind = out.least_variance_m2 < kPlanarRatio * variances_m2[1]
                 ? Neighbourhood::Kind::kPlanar
                 : Neighbourhood::Kind::kVolumetric;
  return out;
}

}  // namespace

PatchSurface::PatchSurface(std::vector<Vector3d> points_m, double reach_m)
    : points_m_(std::move(points_m)), tree_(points_m_) {
  neighbourhoods_.reserve(points_m_.size());
  std::vector<std::size_t> nearest;
  for (const Vector3d& p_m : points_m_) {
    tree_.FindNearest(p_m, kPlaneNeighbours, reach_m, &nearest);
    neighbourhoods_.push_back(Describe(points_m_, nearest));
  }
}

}  // namespace dn::matching_internal
