#pragma once

#include <dn/eigen_alignment.h>

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

namespace dn {

/// Heights of flat ground at the centres of square cells; mapping frame m, m. The sides of the
/// cells are multiples of cell_m east and north.
struct FlatSurface {
  double cell_m = 1.0;
  std::unordered_map<std::uint64_t, double> up_m;  ///< by CellKey

  /// Returns the height of the cell that contains a position; nullopt without flat ground.
  std::optional<double> At(const Eigen::Vector2d& en_m) const;
};

/// Returns the number of the cell that contains a coordinate. A coordinate that is too far away for
/// a number of 32 bits belongs to the last cell.
std::int32_t CellNumber(double x_m, double cell_m);

/// Returns the key of the cell that contains a position, and the centre of the cell of a key.
std::uint64_t CellKey(const Eigen::Vector2d& en_m, double cell_m);
Eigen::Vector2d CellCentre(std::uint64_t key, double cell_m);

/// Collects the points of a strip in cells and fits planes to them. Strips can then be compared on
/// surfaces as in the Lidar Base Specification of USGS. The points of a cell of flat ground spread
/// in both directions. They lie on a plane with a slope below 10 deg, with an rms below 0.1 m.
/// Memory: some 80 bytes per cell, independent of the number of points.
class StripSurface {
 public:
  explicit StripSurface(double cell_m) : cell_m_(cell_m) {}

  /// Adds a point p_m in the mapping frame, m.
  void Add(const Eigen::Vector3d& p_m);

  FlatSurface Flat() const;

 private:
  /// Sums over points relative to the centre of the cell and the height of its first point. Single
  /// precision suffices for such short distances.
  struct Sums {
    float first_up_m = 0.0F, points = 0.0F;
    float east = 0.0F, north = 0.0F, up = 0.0F;
    float east2 = 0.0F, east_north = 0.0F, north2 = 0.0F;
    float east_up = 0.0F, north_up = 0.0F, up2 = 0.0F;
  };

  /// Returns the height of the plane at the centre; nullopt unless the cell is flat ground.
  std::optional<double> FlatHeight(const Sums& sums) const;

  double cell_m_;
  std::unordered_map<std::uint64_t, Sums> cells_;
};

/// Height difference of two strips in a cell.
struct SurfaceDifference {
  std::uint64_t cell = 0;
  double up_m = 0.0;  ///< second minus first
};

/// Returns the differences in all cells that are flat in both, in the order of their keys. Throws
/// InvalidConfig for cells of different sizes.
std::vector<SurfaceDifference> SurfaceDifferences(const FlatSurface& first,
                                                  const FlatSurface& second);

}  // namespace dn
