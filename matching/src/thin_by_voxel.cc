#include <dn/matching/point_cloud.h>
#include <pcl/filters/uniform_sampling.h>
#include <pcl/point_types.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "checks.h"

namespace dn {
namespace {

// PCL numbers the cells of a cloud with an int and stores coordinates as float. Tiles of 1024^3
// cells avoid an overflow and limit the rounding of coordinates to 6e-5 of a cell.
constexpr double kTileCells = 1024.0;
constexpr double kMaxCells = 1e15;

using Tile = std::array<double, 3>;

Tile TileIndex(const Eigen::Vector3d& cells) {
  return {std::floor(cells.x() / kTileCells), std::floor(cells.y() / kTileCells),
          std::floor(cells.z() / kTileCells)};
}

/// Returns the points of a tile in units of a cell, relative to the corner of the tile.
pcl::PointCloud<pcl::PointXYZ>::Ptr LocalCloud(const std::vector<Eigen::Vector3d>& points_m,
                                               const std::vector<std::size_t>& indices,
                                               const Tile& tile, double voxel_m) {
  auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  cloud->reserve(indices.size());
  const Eigen::Vector3d corner = kTileCells * Eigen::Vector3d(tile[0], tile[1], tile[2]);
  for (const std::size_t i : indices) {
    const Eigen::Vector3f p = (points_m[i] / voxel_m - corner).cast<float>();
    cloud->emplace_back(p.x(), p.y(), p.z());
  }
  return cloud;
}

/// Returns which points of a cloud (in units of a cell) are kept.
std::vector<bool> Kept(const pcl::PointCloud<pcl::PointXYZ>::Ptr& cloud) {
  constexpr bool kRememberRemoved = true;
  pcl::UniformSampling<pcl::PointXYZ> sampling(kRememberRemoved);
  sampling.setRadiusSearch(1.0);
  sampling.setInputCloud(cloud);
  pcl::PointCloud<pcl::PointXYZ> thinned;
  sampling.filter(thinned);

  std::vector<bool> kept(cloud->size(), true);
  for (const auto i : *sampling.getRemovedIndices()) kept[static_cast<std::size_t>(i)] = false;
  return kept;
}

}  // namespace

std::vector<std::size_t> ThinByVoxel(const std::vector<Eigen::Vector3d>& points_m, double voxel_m) {
  matching_internal::CheckPositive("voxel", voxel_m);
  matching_internal::CheckPoints(points_m, kMaxCells * voxel_m);

  std::map<Tile, std::vector<std::size_t>> tiles;
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    tiles[TileIndex(points_m[i] / voxel_m)].push_back(i);
  }

  std::vector<std::size_t> result;
  for (const auto& [tile, indices] : tiles) {
    const std::vector<bool> kept = Kept(LocalCloud(points_m, indices, tile, voxel_m));
    for (std::size_t k = 0; k < indices.size(); ++k) {
      if (kept[k]) result.push_back(indices[k]);
    }
  }
  std::sort(result.begin(), result.end());
  return result;
}

}  // namespace dn
