#pragma once

#include <dn/sim/terrain.h>

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace dn {

/// Where a laser ray ends.
struct RayHit {
  double range_m = 0.0;
  bool water = false;
};

/// Intersects rays with the surface of a terrain, many of them near each other: it keeps what it
/// finds of the ground (square tiles: bounds of height and slope, the objects on them), in memory
/// that does not grow. Exact to 1e-9 m of range, also where an object is narrow; where the ground
/// rises through a ray that it all but touches (to less than 1 mm), a hit within some mm of it. Of
/// one thread at a time; the terrain must outlive it.
class TerrainCaster {
 public:
  explicit TerrainCaster(const Terrain& terrain);
  ~TerrainCaster();

  /// The first point of a downward ray (unit direction) on the surface, if that is nearer than
  /// max_range_m. The origin lies above the surface. Throws InvalidInput for a ray that points not
  /// downwards.
  std::optional<RayHit> Cast(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction,
                             double max_range_m);

 private:
  struct Tile;
  struct House;
  struct Crown;
  struct Ray;

  const Tile& TileAt(const Eigen::Vector2i& cell);
  void Survey(const Eigen::Vector2i& cell, Tile* tile) const;
  void BoundGround(const Eigen::Vector2d& centre_en_m, Tile* tile) const;
  void AddHouses(const Eigen::Vector2d& centre_en_m, Tile* tile) const;
  void AddCrowns(const Eigen::Vector2d& centre_en_m, Tile* tile) const;
  std::optional<double> CastInTile(const Tile& tile, const Ray& ray, double from_m,
                                   double to_m) const;
  std::optional<double> GroundHit(const Tile& tile, const Ray& ray, double from_m,
                                  double to_m) const;

  const Terrain& terrain_;
  double curvature_bound_ = 0.0;  // 1/m, of the relief: of its second derivative in any direction
  std::vector<Tile> tiles_;
};

}  // namespace dn
