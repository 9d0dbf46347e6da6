#pragma once

#include <dn/sim/scenario.h>

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace dn {

/// The surface of the Earth in m: rolling ground with buildings and trees on it, as a height over
/// east and north. The same seed gives the same surface everywhere.
class Terrain {
 public:
  explicit Terrain(const TerrainScenario& scenario);

  /// Height (m, up) of the bare ground and of the surface: ground, roof or crown.
  double Ground(const Eigen::Vector2d& en_m) const;
  double Surface(const Eigen::Vector2d& en_m) const;

  /// No surface lies higher, no ground lower.
  double highest_m() const { return highest_m_; }
  double lowest_m() const { return scenario_.base_m - relief_bound_m_; }

  /// Distance along a downward ray (unit direction) to the first point where it meets the surface,
  /// if that is nearer than max_range_m. Objects narrower than 0.25 m along the ray may be missed.
  std::optional<double> Intersect(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction,
                                  double max_range_m) const;

 private:
  struct Wave {
    Eigen::Vector2d wavenumber;  // rad/m
    double phase_rad;
    double amplitude_m;
  };
  /// Objects of one sort: at most one in each cell of a square grid.
  struct Grid {
    double cell_m = 0.0;  // 0: none
    std::uint64_t seed = 0;
  };
  double BuildingTop(const Eigen::Vector2d& en_m) const;
  double TreeTop(const Eigen::Vector2d& en_m) const;
  bool BuiltUp(const Eigen::Vector2d& en_m) const;

  TerrainScenario scenario_;
  std::vector<Wave> waves_;
  Grid buildings_;
  Grid trees_;
  double relief_bound_m_ = 0.0;
  double highest_m_ = 0.0;
};

}  // namespace dn
