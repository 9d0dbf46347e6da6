#pragma once

#include <dn/sim/scenario.h>

#include <Eigen/Core>
#include <memory>

namespace dn {

/// Man-made shape of the ground, added to the relief. It is continuous.
class Landform {
 public:
  /// Heights lie between lowest_m and highest_m; no slope exceeds `slope`.
  struct Bounds {
    double lowest_m = 0.0, highest_m = 0.0, slope = 0.0;
  };

  virtual ~Landform() = default;

  /// Returns the height above the relief, m.
  virtual double At(const Eigen::Vector2d& en_m) const = 0;
  /// Returns the bounds for all places.
  virtual Bounds Everywhere() const = 0;
  /// Returns the bounds for the places within radius_m (up to 15 m) of a place.
  virtual Bounds Near(const Eigen::Vector2d& en_m, double radius_m) const = 0;
};

/// Returns the landform of a kind of terrain; null for the kinds without one.
std::unique_ptr<const Landform> MakeLandform(const TerrainScenario& scenario);

/// Fields with crop rows: ridges of a direction, spacing and height that differ between fields.
std::unique_ptr<const Landform> MakeCropRows(std::uint64_t seed);

/// Pits with benches, and heaps of gravel on their floors.
std::unique_ptr<const Landform> MakeQuarry(std::uint64_t seed);

}  // namespace dn
