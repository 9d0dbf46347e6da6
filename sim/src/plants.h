#pragma once

#include <dn/sim/roughness.h>
#include <dn/sim/scenario.h>

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "plant.h"
#include "terrain_objects.h"

namespace dn {

enum class Species { kForestTree, kFruitTree, kGardenTree, kShrub };

/// Plants that stand on a grid, at most one in each cell.
struct PlantLayer {
  Species species = Species::kForestTree;
  double cell_m = 0.0;
  double jitter = 0.0;    ///< largest distance from the centre of the cell, in cells
  double turn_rad = 0.0;  ///< azimuth of the grid
  std::uint64_t seed = 0;
};

/// All plants of a detailed terrain. The same seed always gives the same plants.
class Plants {
 public:
  explicit Plants(const TerrainScenario& scenario);

  /// Upper bounds of the height and the radius of any plant.
  static constexpr double kTallest_m = 36.0;
  static constexpr double kWidest_m = 5.0;

  bool empty() const { return layers_.empty(); }

  /// Calls visit for each plant whose crown reaches within radius_m of a place. The height of its
  /// foot is left at zero.
  void ForEachNear(const Eigen::Vector2d& en_m, double radius_m,
                   const std::function<void(const Plant&)>& visit) const;

 private:
  std::optional<Plant> PlantIn(const PlantLayer& layer, const Eigen::Vector2i& cell) const;
  Plant Grow(Species species, const Eigen::Vector2d& en_m, CellNumbers* numbers) const;
  Plant ForestTree(const Eigen::Vector2d& en_m, CellNumbers* numbers) const;

  /// Returns whether the plants of a forest grow at a place.
  bool InForest(const Eigen::Vector2d& en_m) const;

  std::vector<PlantLayer> layers_;
  double conifer_share_;
  bool leaves_;
  // Smooth variation over the stand (rms 1) of the height of trees, and of their number.
  Roughness vigour_, density_;
  Roughness woods_;           // a forest covers the places where it is above woods_above_
  double woods_above_ = 0.0;  // -infinity: everywhere
};

}  // namespace dn
