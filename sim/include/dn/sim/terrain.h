#pragma once

#include <dn/sim/roughness.h>
#include <dn/sim/scenario.h>

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

namespace dn {

struct Building;
struct Plant;
struct Scene;
struct Tree;

/// The gable at one end of a house: its peak is where the two sides of the roof meet the wall.
struct Gable {
  Eigen::Vector3d peak_m;   ///< east, north, up
  Eigen::Vector2d outward;  ///< unit vector of the ridge, away from the house
  double slope = 0.0;       ///< of the sides of the roof, rise over run
  double half_width_m = 0.0;

  /// Returns the point of the roof at distances from the peak: back along the ridge, and to the
  /// left of the outward direction (negative: to the right).
  Eigen::Vector3d OnRoof(double back_m, double left_m) const;
};

/// Surface of the Earth in m, as a height over east and north: undulating ground with roughness,
/// water, buildings and trees according to the scenario. The same seed always gives the same
/// surface. Plants that let light through and cars are not part of the surface; only TerrainCaster
/// meets them.
class Terrain {
 public:
  explicit Terrain(const TerrainScenario& scenario);

  /// Height (m, up) of the bare ground, and of the surface (ground, roof or crown).
  double Ground(const Eigen::Vector2d& en_m) const;
  double Surface(const Eigen::Vector2d& en_m) const;

  /// Returns true if the ground is water: it is flat and reflects no laser pulses.
  bool Water(const Eigen::Vector2d& en_m) const;

  /// Returns a gable of the house at a position: the one at the beginning or at the end of its
  /// axis. Returns nullopt without a house with such a roof. A tree may cover it.
  std::optional<Gable> GableAt(const Eigen::Vector2d& en_m, bool at_end) const;

  /// Bounds: no surface is higher than the first, no ground lower than the second.
  double highest_m() const { return highest_m_; }
  double lowest_m() const;
  /// Returns an upper bound of the height of plants above the ground.
  double tallest_plant_m() const;

  /// Returns the distance along a downward ray (unit direction) to the first point on the surface,
  /// if it is less than max_range_m. Objects narrower than 0.25 m along the ray may be missed.
  std::optional<double> Intersect(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction,
                                  double max_range_m) const;

 private:
  friend class TerrainCaster;
  class Objects;
  class AlongRay;

  struct Wave {
    Eigen::Vector2d wavenumber;  // rad/m
    double phase_rad;
    double amplitude_m;
  };
  /// Objects of one kind, at most one in each cell of a square grid.
  struct Grid {
    double cell_m = 0.0;  // 0: no such objects
    std::uint64_t seed = 0;
    double margin_m = 0.5;  // free space between a building and the border of its cell
  };
  double Relief(const Eigen::Vector2d& en_m) const;  // relief without roughness and water
  double DryGround(const Eigen::Vector2d& en_m) const;
  // Returns the height below which the share of water of the scenario lies.
  double WaterLevel() const;
  // Returns the object in a cell; nullopt if the cell is empty.
  std::optional<Building> BuildingIn(const Eigen::Vector2i& cell) const;
  std::optional<Tree> TreeIn(const Eigen::Vector2i& cell) const;
  // Returns an upper bound of the slopes that the landform adds.
  double ShapeSlope() const;
  // Moves a plant onto the ground; returns false where no plant can stand.
  bool SetOnGround(Plant* plant) const;
  // Returns true if a point lies in a built-up area.
  bool BuiltUp(const Eigen::Vector2d& en_m) const;

  TerrainScenario scenario_;
  std::vector<Wave> waves_;
  Grid buildings_;
  Grid trees_;
  Roughness roughness_;
  std::shared_ptr<const Scene> scene_;  // null: the terrain is not detailed
  std::optional<double> water_m_;       // height of all water
  double relief_bound_m_ = 0.0;
  double relief_slope_bound_ = 0.0;
  double above_relief_m_ = 0.0;  // upper bound of all heights above the local relief
  double highest_m_ = 0.0;
};

}  // namespace dn
