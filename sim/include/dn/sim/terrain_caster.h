#pragma once

#include <dn/sim/terrain.h>

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

namespace dn {

/// Surface that a laser ray meets.
enum class Surface { kGround, kWater, kBuilding, kCar, kLowPlant, kHighPlant };

/// End point of a laser ray.
struct RayHit {
  double range_m = 0.0;
  Surface surface = Surface::kGround;
  double cosine = 1.0;  ///< of the angle between the ray and the normal of the surface; about
};

/// Intersects many neighbouring rays with the surface of a terrain. It caches ground data in square
/// tiles (bounds of height and slope, and the objects on a tile) with limited memory. The range is
/// exact to 1e-9 m, also for narrow objects. Where the ground barely touches a ray (by less than 1
/// mm), the hit is within some mm of that point. An object must not be used by several threads at a
/// time. The terrain must outlive it.
class TerrainCaster {
 public:
  /// visit: number of the overflight. Cars that drive are elsewhere on every visit.
  explicit TerrainCaster(const Terrain& terrain, std::uint64_t visit = 0);
  ~TerrainCaster();

  /// Returns the first point of a downward ray (unit direction) on the surface, if it is nearer
  /// than max_range_m. The origin must lie above the surface. Throws InvalidInput for a ray that
  /// does not point downwards.
  std::optional<RayHit> Cast(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction,
                             double max_range_m);

 private:
  struct Tile;
  struct House;
  struct Crown;
  struct Ray;

  // Returns the tile of a cell from the cache; surveys it if necessary.
  const Tile& TileAt(const Eigen::Vector2i& cell);
  // Fills a tile: bounds of the ground and objects.
  void Survey(const Eigen::Vector2i& cell, Tile* tile) const;
  void BoundGround(const Eigen::Vector2d& centre_en_m, Tile* tile) const;
  void AddHouses(const Eigen::Vector2d& centre_en_m, Tile* tile) const;
  void AddCrowns(const Eigen::Vector2d& centre_en_m, Tile* tile) const;
  void AddPlants(const Eigen::Vector2d& centre_en_m, Tile* tile) const;
  void AddCars(const Eigen::Vector2d& centre_en_m, Tile* tile) const;
  // Returns the first hit in a tile, between two ranges.
  std::optional<RayHit> CastInTile(const Tile& tile, const Ray& ray, double from_m,
                                   double to_m) const;
  std::optional<RayHit> FirstPlant(const Tile& tile, const Ray& ray, double from_m,
                                   double to_m) const;
  std::optional<double> GroundHit(const Tile& tile, const Ray& ray, double from_m,
                                  double to_m) const;

  const Terrain& terrain_;
  std::uint64_t visit_;
  double tile_m_, tile_radius_m_;
  int tiles_per_row_;
  // Bound of the second derivative of the relief in any direction, 1/m.
  double curvature_bound_ = 0.0;
  std::vector<Tile> tiles_;
};

}  // namespace dn
