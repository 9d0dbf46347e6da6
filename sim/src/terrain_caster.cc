#include <dn/error.h>
#include <dn/sim/terrain_caster.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "ray_stretch.h"
#include "scene.h"
#include "terrain_objects.h"

namespace dn {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;
using Eigen::Vector3d;

constexpr double kTile_m = 16.0;
constexpr double kDetailedTile_m = 4.0;  // a tile of a forest then has some ten plants
// Number of tiles in a row and a column of the cache, powers of two.
constexpr int kTilesPerRow = 64, kDetailedTilesPerRow = 256;
constexpr double kNear_m = 1e-3;  // above ground
constexpr double kOnGround_m = 1e-11;
constexpr double kSameRange_m = 1e-10;
constexpr double kNowhere = Stretch::kNowhere;
// A wall is seen from above at a small angle; this is a usual cosine.
constexpr double kWallCosine = 0.3;

/// Returns the first root of a t^2 + 2 b t + c in the stretch; the function is positive at its
/// start.
std::optional<double> FirstRoot(double a, double b, double c, const Stretch& stretch) {
  const double discriminant = b * b - a * c;
  if (discriminant < 0.0) return std::nullopt;
  const double q = -(b + std::copysign(std::sqrt(discriminant), b));
  double first = q / a, second = c / q;
  if (!(first <= second)) std::swap(first, second);
  for (const double root : {first, second}) {
    if (root >= stretch.from_m && root <= stretch.to_m) return root;
  }
  return std::nullopt;
}

/// Returns the root of a function that is positive at a and not positive at b (Illinois method).
template <class F>
double RootBetween(const F& clearance_m, double a, double at_a, double b, double at_b) {
  constexpr int kMostSteps = 60;
  for (int step = 0; step < kMostSteps && std::abs(b - a) > kSameRange_m; ++step) {
    const double t = b - at_b * (b - a) / (at_b - at_a);
    const double at_t = clearance_m(t);
    if (std::abs(at_t) < kOnGround_m) return t;
    if ((at_t > 0.0) == (at_b > 0.0)) {
      at_a *= 0.5;
    } else {
      a = b;
      at_a = at_b;
    }
    b = t;
    at_b = at_t;
  }
  return b;
}

}  // namespace

struct TerrainCaster::House {
  static constexpr Surface kSurface = Surface::kBuilding;

  Building building;
  double ground_m;

  /// Returns the cosine of incidence of a ray that ends at a point of the house.
  double Cosine(const Vector3d& direction, const Vector3d& end_m) const;
};

struct TerrainCaster::Crown {
  static constexpr Surface kSurface = Surface::kHighPlant;

  Tree tree;
  double ground_m;

  static double Cosine(const Vector3d& direction, const Vector3d&) { return -direction.z(); }
};

double TerrainCaster::House::Cosine(const Vector3d& direction, const Vector3d& end_m) const {
  const double across_m = building.ToAxes(end_m.head<2>()).y();
  if (end_m.z() < ground_m + building.RoofAcross(across_m) - kNear_m) return kWallCosine;
  const Vector2d across_axis(-building.axis.y(), building.axis.x());
  const double rise =
      building.gabled ? -std::copysign(building.slope, across_m) : 0.5 * building.slope;
  Vector3d normal = Vector3d::UnitZ();
  normal.head<2>() = -rise * across_axis;
  return std::max(0.0, -direction.dot(normal.normalized()));
}

struct TerrainCaster::Tile {
  Vector2i cell = Vector2i::Constant(std::numeric_limits<int>::min());
  double ground_top_m = 0.0;            // the ground is nowhere higher
  double top_m = 0.0;                   // nothing on the tile is higher
  double slope = 0.0;                   // the ground is nowhere steeper
  Vector3d normal = Vector3d::UnitZ();  // normal of the ground at the centre
  std::vector<House> houses;
  std::vector<Crown> crowns;
  std::vector<Plant> plants;
  std::vector<Car> cars;
};

struct TerrainCaster::Ray : LaserRay {
  using LaserRay::LaserRay;

  /// Returns the range at which the ray meets a wall or the roof of the house.
  std::optional<double> Hit(const House& house, const Stretch& within) const;
  /// Returns the range at which the ray meets the edge or the top of the crown.
  std::optional<double> Hit(const Crown& crown, const Stretch& within) const;
};

std::optional<double> TerrainCaster::Ray::Hit(const House& house, const Stretch& within) const {
  const Building& building = house.building;
  const Vector2d start = building.ToAxes(origin_m.head<2>());
  const Vector2d rate(direction.head<2>().dot(building.axis),
                      building.axis.x() * direction.y() - building.axis.y() * direction.x());
  const Stretch over = within.Within(start.x(), rate.x(), building.half_length_m)
                           .Within(start.y(), rate.y(), building.half_width_m);
  if (over.empty()) return std::nullopt;
  const auto clearance_m = [&](double range_m) {
    const double across_m = start.y() + range_m * rate.y();
    return Height(range_m) - house.ground_m - building.RoofAcross(across_m);
  };
  double from_m = over.from_m, at_from_m = clearance_m(from_m);
  if (at_from_m <= 0.0) return from_m;
  const double ridge_m = -start.y() / rate.y();
  const bool crosses_ridge = building.gabled && ridge_m > over.from_m && ridge_m < over.to_m;
  for (const double to_m : {crosses_ridge ? ridge_m : over.to_m, over.to_m}) {
    const double at_to_m = clearance_m(to_m);  // the clearance is linear between both ranges
    if (at_to_m <= 0.0) return from_m + (to_m - from_m) * at_from_m / (at_from_m - at_to_m);
    from_m = to_m;
    at_from_m = at_to_m;
  }
  return std::nullopt;
}

std::optional<double> TerrainCaster::Ray::Hit(const Crown& crown, const Stretch& within) const {
  const Tree& tree = crown.tree;
  const Vector2d start = origin_m.head<2>() - tree.centre_en_m;
  const Vector2d rate = direction.head<2>();
  const double closest_m = across > 0.0 ? -start.dot(rate) / (across * across) : 0.0;
  const double miss2 = (start + closest_m * rate).squaredNorm();
  const double chord2 = tree.radius_m * tree.radius_m - miss2;
  if (chord2 < 0.0) return std::nullopt;
  Stretch over = within;
  if (across > 0.0) over = within.Within(-closest_m, 1.0, std::sqrt(chord2) / across);
  if (over.empty()) return std::nullopt;
  // The height above the crown is c + 2 b s + a s^2, with s the range from the closest point.
  const double fall = Tree::kDroop * tree.height_m / (tree.radius_m * tree.radius_m);
  const double a = fall * across * across, b = 0.5 * direction.z();
  const double c = Height(closest_m) - crown.ground_m - tree.height_m + fall * miss2;
  const Stretch behind{over.from_m - closest_m, over.to_m - closest_m};
  if (c + behind.from_m * (2.0 * b + a * behind.from_m) <= 0.0) return over.from_m;
  if (a == 0.0) {
    const double s = -0.5 * c / b;
    return s <= behind.to_m ? std::optional(closest_m + s) : std::nullopt;
  }
  const auto s = FirstRoot(a, b, c, behind);
  return s ? std::optional(closest_m + *s) : std::nullopt;
}

TerrainCaster::TerrainCaster(const Terrain& terrain, std::uint64_t visit)
    : terrain_(terrain),
      visit_(visit),
      tile_m_(terrain.scene_ ? kDetailedTile_m : kTile_m),
      tile_radius_m_(0.5 * std::numbers::sqrt2 * tile_m_),
      tiles_per_row_(terrain.scene_ ? kDetailedTilesPerRow : kTilesPerRow),
      tiles_(static_cast<std::size_t>(tiles_per_row_ * tiles_per_row_)) {
  for (const Terrain::Wave& wave : terrain_.waves_) {
    curvature_bound_ += wave.amplitude_m * wave.wavenumber.squaredNorm();
  }
}

TerrainCaster::~TerrainCaster() = default;

const TerrainCaster::Tile& TerrainCaster::TileAt(const Vector2i& cell) {
  const int mask = tiles_per_row_ - 1;  // neighbouring tiles never share a place
  const int place = (cell.y() & mask) * tiles_per_row_ + (cell.x() & mask);
  Tile& tile = tiles_[static_cast<std::size_t>(place)];
  if (tile.cell != cell) Survey(cell, &tile);
  return tile;
}

void TerrainCaster::Survey(const Vector2i& cell, Tile* tile) const {
  const Vector2d centre_en_m = (cell.cast<double>() + Vector2d::Constant(0.5)) * tile_m_;
  tile->cell = cell;
  BoundGround(centre_en_m, tile);
  tile->top_m = tile->ground_top_m;
  tile->houses.clear();
  tile->crowns.clear();
  if (terrain_.buildings_.cell_m > 0.0) AddHouses(centre_en_m, tile);
  if (terrain_.trees_.cell_m > 0.0) AddCrowns(centre_en_m, tile);
  tile->plants.clear();
  tile->cars.clear();
  if (!terrain_.scene_) return;
  AddPlants(centre_en_m, tile);
  if (terrain_.buildings_.cell_m > 0.0) AddCars(centre_en_m, tile);
}

void TerrainCaster::BoundGround(const Vector2d& centre_en_m, Tile* tile) const {
  Vector2d gradient = Vector2d::Zero();
  for (const Terrain::Wave& wave : terrain_.waves_) {
    const double phase_rad = wave.wavenumber.dot(centre_en_m) + wave.phase_rad;
    gradient += wave.amplitude_m * std::cos(phase_rad) * wave.wavenumber;
  }
  const double bend = curvature_bound_ * tile_radius_m_;
  const double slope = gradient.norm();
  const Roughness& roughness = terrain_.roughness_;
  tile->slope = std::min(terrain_.relief_slope_bound_, slope + bend) + roughness.slope_bound();
  tile->ground_top_m =
      terrain_.Relief(centre_en_m) + (slope + 0.5 * bend) * tile_radius_m_ + roughness.bound_m();
  tile->normal = Vector3d(-gradient.x(), -gradient.y(), 1.0).normalized();
  if (terrain_.scene_ && terrain_.scene_->landform) {
    const Landform::Bounds shape = terrain_.scene_->landform->Near(centre_en_m, tile_radius_m_);
    tile->slope += shape.slope;
    tile->ground_top_m += shape.highest_m;
  }
  if (terrain_.water_m_) tile->ground_top_m = std::max(tile->ground_top_m, *terrain_.water_m_);
}

/// Calls visit(cell) for the cells of a grid that overlap a square.
template <class Visit>
void ForCells(const Vector2d& centre_en_m, double edge_m, double cell_m, const Visit& visit) {
  const Vector2d half = Vector2d::Constant(0.5 * edge_m);
  const Vector2i first = CellAt(centre_en_m - half, cell_m);
  const Vector2i last = CellAt(centre_en_m + half, cell_m);
  for (int x = first.x(); x <= last.x(); ++x) {
    for (int y = first.y(); y <= last.y(); ++y) visit(Vector2i(x, y));
  }
}

void TerrainCaster::AddHouses(const Vector2d& centre_en_m, Tile* tile) const {
  ForCells(centre_en_m, tile_m_, terrain_.buildings_.cell_m, [&](const Vector2i& cell) {
    const auto building = terrain_.BuildingIn(cell);
    if (!building) return;
    const double apart_m = (building->centre_en_m - centre_en_m).norm();
    if (apart_m > tile_radius_m_ + building->radius_m()) return;
    tile->houses.push_back({*building, terrain_.Relief(building->centre_en_m)});
    tile->top_m = std::max(tile->top_m, tile->houses.back().ground_m + building->highest_m());
  });
}

void TerrainCaster::AddCrowns(const Vector2d& centre_en_m, Tile* tile) const {
  ForCells(centre_en_m, tile_m_, terrain_.trees_.cell_m, [&](const Vector2i& cell) {
    const auto tree = terrain_.TreeIn(cell);
    if (!tree) return;
    const double apart_m = (tree->centre_en_m - centre_en_m).norm();
    if (apart_m > tile_radius_m_ + tree->radius_m) return;
    tile->crowns.push_back({*tree, terrain_.Relief(tree->centre_en_m)});
    tile->top_m = std::max(tile->top_m, tile->crowns.back().ground_m + tree->height_m);
  });
}

void TerrainCaster::AddPlants(const Vector2d& centre_en_m, Tile* tile) const {
  terrain_.scene_->plants.ForEachNear(centre_en_m, tile_radius_m_, [&](const Plant& grown) {
    Plant plant = grown;
    if (!terrain_.SetOnGround(&plant)) return;
    tile->plants.push_back(plant);
    tile->top_m = std::max(tile->top_m, plant.foot_m.z() + plant.height_m);
  });
}

void TerrainCaster::AddCars(const Vector2d& centre_en_m, Tile* tile) const {
  // A square has the cars on its western and southern border, half of them outside of it.
  const double reach_m = tile_m_ + 2.0 * Streets::kHalfWidth_m;
  ForCells(centre_en_m, reach_m, terrain_.buildings_.cell_m, [&](const Vector2i& square) {
    for (Car& car : terrain_.scene_->streets.CarsAt(square, visit_)) {
      const double apart_m = (car.centre_en_m() - centre_en_m).norm();
      if (apart_m > tile_radius_m_ + Streets::kLongestCar_m) continue;
      car.RaiseBy(terrain_.Ground(car.centre_en_m()));
      tile->top_m = std::max(tile->top_m, car.cabin_m.max().z());
      tile->cars.push_back(car);
    }
  });
}

/// The steps are so short that the ground cannot reach the ray in between, given the slope of the
/// tile. If the clearance decreases everywhere, the search goes directly to its only root.
std::optional<double> TerrainCaster::GroundHit(const Tile& tile, const Ray& ray, double from_m,
                                               double to_m) const {
  const auto clearance_m = [&](double range_m) {
    return ray.Height(range_m) - terrain_.Ground(ray.Place(range_m));
  };
  const double sink = -ray.direction.z();
  const double fastest = sink + tile.slope * ray.across;
  const double slowest = sink - tile.slope * ray.across;
  double t = std::max(from_m, ray.RangeAtHeight(tile.ground_top_m));
  while (t <= to_m) {
    const double above_m = clearance_m(t);
    if (above_m <= kOnGround_m) return t;
    if (slowest > 0.0 || above_m < kNear_m) {
      const double reach_m = slowest > 0.0 ? above_m / slowest : 4.0 * above_m / sink;
      const double ahead = std::min(to_m, t + reach_m);
      const double at_ahead_m = clearance_m(ahead);
      if (at_ahead_m <= 0.0) return RootBetween(clearance_m, t, above_m, ahead, at_ahead_m);
      if (slowest > 0.0 && ahead == to_m) return std::nullopt;
      if (slowest > 0.0) return ahead;
    }
    t += std::max(above_m / fastest, kSameRange_m);
  }
  return std::nullopt;
}

std::optional<RayHit> TerrainCaster::FirstPlant(const Tile& tile, const Ray& ray, double from_m,
                                                double to_m) const {
  std::optional<RayHit> first;
  for (const Plant& plant : tile.plants) {
    const double before_m = first ? first->range_m : to_m;
    const auto hit = plant.FirstHit(ray, {from_m, before_m});
    if (hit && hit->range_m <= before_m) first = hit;
  }
  return first;
}

std::optional<RayHit> TerrainCaster::CastInTile(const Tile& tile, const Ray& ray, double from_m,
                                                double to_m) const {
  std::optional<RayHit> first = FirstPlant(tile, ray, from_m, to_m);
  const double before_m = first ? first->range_m : to_m;
  const auto on_ground_m = GroundHit(tile, ray, from_m, before_m);
  if (on_ground_m) first = {*on_ground_m, Surface::kGround, -ray.direction.dot(tile.normal)};
  const auto meet = [&](const auto& object) {
    const auto hit_m = ray.Hit(object, {from_m, std::min(to_m, first ? first->range_m : kNowhere)});
    if (!hit_m || (first && first->range_m <= *hit_m)) return;
    first = {*hit_m, object.kSurface, object.Cosine(ray.direction, ray.At(*hit_m))};
  };
  std::for_each(tile.houses.begin(), tile.houses.end(), meet);
  std::for_each(tile.crowns.begin(), tile.crowns.end(), meet);
  for (const Car& car : tile.cars) {
    const double nearest_m = first ? first->range_m : to_m;
    const auto hit_m = car.FirstHit(ray.origin_m, ray.direction, {from_m, nearest_m});
    if (hit_m) first = {*hit_m, Surface::kCar, -ray.direction.z()};
  }
  return first;
}

std::optional<RayHit> TerrainCaster::Cast(const Vector3d& origin_m, const Vector3d& direction,
                                          double max_range_m) {
  if (!(direction.z() < 0.0)) throw InvalidInput("a laser ray must point downwards");
  const Ray ray(origin_m, direction);
  double from_m = std::max(0.0, ray.RangeAtHeight(terrain_.highest_m()));
  Vector2i cell = CellAt(ray.Place(from_m), tile_m_);
  Vector2i step;
  // Ranges at which the ray leaves the tile to the east or west, and to the north or south.
  Vector2d exit_m, spacing_m;
  for (int k = 0; k < 2; ++k) {
    step[k] = direction[k] > 0.0 ? 1 : -1;
    spacing_m[k] = direction[k] == 0.0 ? kNowhere : tile_m_ / std::abs(direction[k]);
    const double border_m = (cell[k] + (step[k] > 0 ? 1 : 0)) * tile_m_;
    exit_m[k] = direction[k] == 0.0 ? kNowhere : (border_m - origin_m[k]) / direction[k];
  }
  while (from_m < max_range_m) {
    const int k = exit_m.x() < exit_m.y() ? 0 : 1;
    const double to_m = std::min(exit_m[k], max_range_m);
    const Tile& tile = TileAt(cell);
    if (ray.Height(to_m) <= tile.top_m) {
      auto hit = CastInTile(tile, ray, from_m, to_m);
      if (hit) {
        const double up_m = ray.Height(hit->range_m);
        const bool low = terrain_.water_m_ && up_m < *terrain_.water_m_ + kNear_m;
        if (low && terrain_.Water(ray.Place(hit->range_m))) {
          hit->surface = Surface::kWater;
          hit->cosine = -direction.z();
        }
        return hit;
      }
    }
    from_m = std::max(from_m, to_m);
    exit_m[k] += spacing_m[k];
    cell[k] += step[k];
  }
  return std::nullopt;
}

}  // namespace dn
