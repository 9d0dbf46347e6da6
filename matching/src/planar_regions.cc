#include <dn/error.h>
#include <dn/matching/planar_regions.h>
#include <dn/matching/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/region_growing.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <string>
#include <utility>

namespace dn {
namespace {

using Eigen::Vector3d;
using Indices = std::vector<std::size_t>;

constexpr double kLeastPlanarity = 0.2;  // of a neighbourhood: excludes edges of walls and wires
constexpr unsigned kNeighboursOfGrowth = 20;  // neighbours examined in region growing
constexpr double kRoughestRms_m = 0.08;       // of a plane, whatever the spacing of its points
constexpr double kTrimSigmas = 3.0;
constexpr int kTrims = 3;
constexpr std::size_t kUnknowns = 3;

std::vector<Vector3d> At(const std::vector<Vector3d>& points_m, const Indices& at) {
  std::vector<Vector3d> out;
  out.reserve(at.size());
  for (const std::size_t i : at) out.push_back(points_m[i]);
  return out;
}

/// The points with a flat neighbourhood and their normals.
struct FlatPoints {
  Indices at;
  pcl::PointCloud<pcl::PointXYZ>::Ptr cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  pcl::PointCloud<pcl::Normal>::Ptr normals = pcl::make_shared<pcl::PointCloud<pcl::Normal>>();
};

FlatPoints FindPlateauUnknown(const std::vector<Vector3d>& points_m,
                              const PlanarRegionOptions& options) {
  Indices all(points_m.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  const std::vector<LocalPlane> planes = FitLocalPlanes(points_m, all, options.normal_radius_m);
  FlatPoints flat;
  for (const std::size_t i : all) {
    const LocalPlane& plane = planes[i];
    if (plane.planarity < kLeastPlanarity || plane.rms_m > options.max_rms_m) continue;
    flat.at.push_back(i);
    const Eigen::Vector3f p = (points_m[i] - points_m[0]).cast<float>();
    flat.cloud->emplace_back(p.x(), p.y(), p.z());
    const Eigen::Vector3f n = plane.normal.cast<float>();
    pcl::Normal normal(n.x(), n.y(), n.z());
    normal.curvature = static_cast<float>(plane.rms_m);  // the flattest points are the first seeds
    flat.normals->push_back(normal);
  }
  return flat;
}

std::vector<Indices> Grow(const FlatPoints& flat, const PlanarRegionOptions& options) {
  std::vector<Indices> regions;
  if (flat.at.size() < std::max<std::size_t>(options.min_points, kNeighboursOfGrowth))
    return regions;
  pcl::RegionGrowing<pcl::PointXYZ, pcl::Normal> growing;
  growing.setInputCloud(flat.cloud);
  growing.setInputNormals(flat.normals);
  growing.setSearchMethod(pcl::make_shared<pcl::search::KdTree<pcl::PointXYZ>>());
  growing.setNumberOfNeighbours(kNeighboursOfGrowth);
  growing.setSmoothModeFlag(false);  // normals are compared with the seed, not from point to point
  growing.setCurvatureTestFlag(false);
  growing.setSmoothnessThreshold(static_cast<float>(options.smoothness_rad));
  growing.setMinClusterSize(static_cast<pcl::uindex_t>(options.min_points));
  std::vector<pcl::PointIndices> clusters;
  growing.extract(clusters);
  for (const pcl::PointIndices& cluster : clusters) {
    Indices region;
    for (const auto i : cluster.indices) region.push_back(flat.at[static_cast<std::size_t>(i)]);
    std::sort(region.begin(), region.end());
    regions.push_back(std::move(region));
  }
  return regions;
}

/// Cuts a region into squares of a grid common to all strips.
std::vector<Indices> Cut(const std::vector<Vector3d>& points_m, Indices region, double side_m) {
  Eigen::Array2d low = points_m[region.front()].head<2>(), high = low;
  for (const std::size_t i : region) {
    low = low.min(points_m[i].head<2>().array());
    high = high.max(points_m[i].head<2>().array());
  }
  if ((high - low).maxCoeff() <= side_m) return {std::move(region)};
  std::map<std::pair<double, double>, Indices> cells;
  for (const std::size_t i : region) {
    cells[{std::floor(points_m[i].x() / side_m), std::floor(points_m[i].y() / side_m)}].push_back(
        i);
  }
  std::vector<Indices> out;
  for (auto& [cell, points] : cells) out.push_back(std::move(points));
  return out;
}

PlanarRegion FitTrimmed(const std::vector<Vector3d>& points_m, Indices at) {
  PlanarRegion region = FitRegion(At(points_m, at));
  for (int trim = 0; trim < kTrims; ++trim) {
    const auto far = [&](std::size_t i) {
      return std::abs(region.normal.dot(points_m[i] - region.centroid_m)) >
             kTrimSigmas * region.rms_m;
    };
    if (std::erase_if(at, far) == 0) break;
    region = FitRegion(At(points_m, at));
  }
  region.points = std::move(at);
  return region;
}

bool Accepted(const PlanarRegion& region, const PlanarRegionOptions& options) {
  return region.points.size() >= options.min_points && region.rms_m <= options.max_rms_m &&
         region.short_side_m >= options.min_extent_m;
}

}  // namespace

PlanarRegionOptions PlanarRegionOptions::ForSpacing(double spacing_m) {
  PlanarRegionOptions options;
  options.normal_radius_m = std::max(options.normal_radius_m, 3.0 * spacing_m);
  options.min_extent_m = std::max(options.min_extent_m, 6.0 * spacing_m);
  options.max_extent_m = std::max(options.max_extent_m, 4.0 * options.min_extent_m);
  options.max_rms_m = std::clamp(spacing_m / 6.0, options.max_rms_m, kRoughestRms_m);
  return options;
}

void PlanarRegionOptions::Validate() const {
  const std::pair<const char*, double> lengths[] = {{"normal_radius_m", normal_radius_m},
                                                    {"smoothness_rad", smoothness_rad},
                                                    {"max_rms_m", max_rms_m},
                                                    {"min_extent_m", min_extent_m},
                                                    {"max_extent_m", max_extent_m}};
  for (const auto& [name, value] : lengths) {
    if (std::isfinite(value) && value > 0.0) continue;
    throw InvalidConfig(std::string(name) + " is " + std::to_string(value) +
                        ", must be positive and finite");
  }
  if (min_points <= kUnknowns) {
    throw InvalidConfig("min_points is " + std::to_string(min_points) + ", must be at least 4");
  }
}

PlanarRegion FitRegion(const std::vector<Vector3d>& points_m) {
  PlanarRegion region;
  const std::size_t n = points_m.size();
  if (n <= kUnknowns) return region;
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& p : points_m) sum += p - points_m[0];
  region.centroid_m = points_m[0] + sum / static_cast<double>(n);
  Eigen::Matrix3d C = Eigen::Matrix3d::Zero();
  for (const Vector3d& p : points_m) {
    const Vector3d d = p - region.centroid_m;
    C += d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(C);
  const Vector3d moments = eigen.eigenvalues().cwiseMax(0.0);
  region.normal = eigen.eigenvectors().col(0);
  if (region.normal.z() < 0.0) region.normal = -region.normal;
  region.rms_m = std::sqrt(moments[0] / static_cast<double>(n - kUnknowns));
  constexpr double kSideOfVariance = 12.0;  // a uniform distribution has the variance side^2 / 12
  const double scale = kSideOfVariance / static_cast<double>(n);
  region.short_side_m = std::sqrt(scale * moments[1]);
  region.long_side_m = std::sqrt(scale * moments[2]);
  return region;
}

std::vector<PlanarRegion> GrowPlanarRegions(const std::vector<Vector3d>& points_m,
                                            const PlanarRegionOptions& options) {
  options.Validate();
  std::vector<PlanarRegion> accepted;
  if (points_m.size() < options.min_points) return accepted;
  for (Indices& grown : Grow(FindPlateauUnknown(points_m, options), options)) {
    for (Indices& part : Cut(points_m, std::move(grown), options.max_extent_m)) {
      PlanarRegion region = FitTrimmed(points_m, std::move(part));
      if (Accepted(region, options)) accepted.push_back(std::move(region));
    }
  }
  return accepted;
}

}  // namespace dn
