#include "plants.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "terrain_objects.h"

namespace dn {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;

// The coarsest lattice of Roughness is 8 m; the stand varies eight times as slowly.
constexpr double kStandScale = 8.0;
constexpr double kWoodsScale = 25.0;  // woods have a size of some 200 m
constexpr double kWoodsTreesPerKm2 = 45000.0;
constexpr double kClearing = -1.0;  // no trees grow where the density is below this
constexpr double kTreeCube_m = 0.4, kShrubCube_m = 0.15;
constexpr double kBareShare = 0.25;  // leaf clusters that remain as branches in winter

double PlantSpacing(double per_km2) { return 1000.0 / std::sqrt(per_km2); }

/// Returns the plants that are usual for a kind of terrain.
std::vector<Species> UsualSpecies(TerrainKind kind) {
  switch (kind) {
    case TerrainKind::kForest:
      return {Species::kForestTree, Species::kShrub};
    case TerrainKind::kOrchard:
      return {Species::kFruitTree};
    case TerrainKind::kTown:
    case TerrainKind::kFields:
    case TerrainKind::kQuarry:
      return {Species::kGardenTree};
    default:
      return {Species::kForestTree, Species::kShrub};  // of its woods
  }
}

/// Returns the value that a field of rms 1 exceeds in this share of the ground, from samples.
double ExceededIn(double share, const Roughness& field) {
  constexpr int kSamples = 100;  // in each direction
  constexpr double kSpacing_m = 3.7;
  if (share >= 1.0) return -std::numeric_limits<double>::infinity();
  std::vector<double> values;
  for (int i = 0; i < kSamples; ++i) {
    for (int j = 0; j < kSamples; ++j) values.push_back(field.At(kSpacing_m * Vector2d(i, j)));
  }
  const double last = static_cast<double>(values.size() - 1);
  const auto at = values.begin() + std::lround((1.0 - share) * last);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

Plant Shrub(CellNumbers* numbers) {
  Plant plant;
  plant.height_m = numbers->Next(0.3, 2.5);
  plant.radius_m = numbers->Next(0.7, 1.7);
  plant.cell_m = kShrubCube_m;
  plant.leaf_share = 0.35;
  return plant;
}

Plant GardenTree(CellNumbers* numbers) {
  Plant plant;
  plant.height_m = numbers->Next(3.0, 12.0);
  plant.crown_base_m = 0.3 * plant.height_m;
  plant.radius_m = std::min(4.0, plant.height_m * numbers->Next(0.25, 0.4));
  plant.trunk_radius_m = 0.015 * plant.height_m;
  plant.cell_m = kTreeCube_m;
  plant.leaf_share = 0.4;
  return plant;
}

Plant FruitTree(CellNumbers* numbers) {
  Plant plant;
  plant.height_m = numbers->Next(3.2, 4.2);
  plant.crown_base_m = 0.8;
  plant.radius_m = numbers->Next(1.3, 1.8);
  plant.trunk_radius_m = 0.08;
  plant.cell_m = 0.5 * kTreeCube_m;
  plant.leaf_share = 0.2;
  return plant;
}

}  // namespace

Plants::Plants(const TerrainScenario& scenario)
    : conifer_share_(scenario.conifer_share),
      leaves_(scenario.leaves),
      vigour_(1.0, MixBits(scenario.seed) ^ 5),
      density_(1.0, MixBits(scenario.seed) ^ 6),
      woods_(1.0, MixBits(scenario.seed) ^ 7) {
  constexpr double kShrubsPerTree = 2.5;
  const double woods_share = IsDetailed(scenario.kind) ? 1.0 : scenario.woods_share;
  const double trees_per_km2 =
      IsDetailed(scenario.kind) ? scenario.trees_per_km2 : kWoodsTreesPerKm2;
  if (trees_per_km2 == 0.0 || woods_share == 0.0) return;
  woods_above_ = ExceededIn(woods_share, woods_);
  for (const Species species : UsualSpecies(scenario.kind)) {
    PlantLayer layer{species};
    const double share = species == Species::kShrub ? kShrubsPerTree : 1.0;
    layer.cell_m = PlantSpacing(share * trees_per_km2);
    layer.jitter = species == Species::kFruitTree ? 0.05 : 0.45;
    layer.turn_rad = static_cast<double>(scenario.seed % 180) * 1.3 + 0.2;
    layer.seed = MixBits(MixBits(scenario.seed) + 4 + layers_.size());
    layers_.push_back(layer);
  }
}

Plant Plants::ForestTree(const Vector2d& en_m, CellNumbers* numbers) const {
  const double vigour = std::clamp(1.0 + 0.22 * vigour_.At(en_m / kStandScale), 0.4, 1.6);
  const bool conifer = numbers->Next() < conifer_share_;
  Plant plant;
  plant.height_m = std::min(kTallest_m, vigour * numbers->Next(6.0, 23.0));
  plant.crown_base_m = plant.height_m * numbers->Next(0.1, 0.4);
  plant.radius_m = std::min(kWidest_m, 0.8 + plant.height_m * (conifer ? 0.12 : 0.14));
  plant.trunk_radius_m = 0.01 * plant.height_m;
  plant.cell_m = kTreeCube_m;
  plant.crown = conifer ? Plant::Crown::kCone : Plant::Crown::kEllipsoid;
  plant.leaf_share = conifer ? 0.99 : 0.9;
  if (!conifer && !leaves_) plant.leaf_share *= kBareShare;
  return plant;
}

Plant Plants::Grow(Species species, const Vector2d& en_m, CellNumbers* numbers) const {
  switch (species) {
    case Species::kForestTree:
      return ForestTree(en_m, numbers);
    case Species::kFruitTree:
      return FruitTree(numbers);
    case Species::kGardenTree:
      return GardenTree(numbers);
    case Species::kShrub:
      return Shrub(numbers);
  }
  return {};
}

std::optional<Plant> Plants::PlantIn(const PlantLayer& layer, const Vector2i& cell) const {
  CellNumbers numbers(layer.seed, cell);
  const double east = numbers.Next(-layer.jitter, layer.jitter);
  const double north = numbers.Next(-layer.jitter, layer.jitter);
  const Vector2d at = cell.cast<double>() + Vector2d::Constant(0.5) + Vector2d(east, north);
  const Vector2d en_m = Eigen::Rotation2Dd(layer.turn_rad) * (layer.cell_m * at);
  const bool forest_tree = layer.species == Species::kForestTree;
  if (forest_tree && density_.At(en_m / kStandScale) < kClearing) return std::nullopt;
  if ((forest_tree || layer.species == Species::kShrub) && !InForest(en_m)) return std::nullopt;
  Plant plant = Grow(layer.species, en_m, &numbers);
  if (!leaves_ && layer.species != Species::kForestTree) plant.leaf_share *= kBareShare;
  plant.foot_m.head<2>() = en_m;
  plant.seed = static_cast<std::uint64_t>(numbers.Next() * 0x1.0p53);
  return plant;
}

bool Plants::InForest(const Vector2d& en_m) const {
  return std::isinf(woods_above_) || woods_.At(en_m / kWoodsScale) > woods_above_;
}

void Plants::ForEachNear(const Vector2d& en_m, double radius_m,
                         const std::function<void(const Plant&)>& visit) const {
  const double reach_m = radius_m + kWidest_m;
  for (const PlantLayer& layer : layers_) {
    const Vector2d at_m = Eigen::Rotation2Dd(-layer.turn_rad) * en_m;
    const Vector2i first = CellAt(at_m - Vector2d::Constant(reach_m), layer.cell_m);
    const Vector2i last = CellAt(at_m + Vector2d::Constant(reach_m), layer.cell_m);
    for (int x = first.x(); x <= last.x(); ++x) {
      for (int y = first.y(); y <= last.y(); ++y) {
        const auto plant = PlantIn(layer, {x, y});
        if (!plant) continue;
        const double apart_m = (plant->foot_m.head<2>() - en_m).norm();
        if (apart_m < radius_m + plant->radius_m) visit(*plant);
      }
    }
  }
}

}  // namespace dn
