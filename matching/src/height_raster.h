#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace dn::matching_internal {

/// A horizontal grid in the map frame. Cell (x, y) has its centre at origin + cell (x + 1/2, y +
/// 1/2).
struct RasterGrid {
  Eigen::Vector2d origin_en_m = Eigen::Vector2d::Zero();
  double cell_m = 1.0;
  int nx = 0, ny = 0;

  std::size_t cells() const { return static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny); }
  bool Has(int x, int y) const { return x >= 0 && y >= 0 && x < nx && y < ny; }
  std::size_t Index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(nx) + static_cast<std::size_t>(x);
  }
  Eigen::Vector2i CellIndex(const Eigen::Vector2d& en_m) const {
    return ((en_m - origin_en_m) / cell_m).array().floor().cast<int>();
  }
};

/// Height of the highest point in each cell. The highest is used because each strip sees walls from
/// one side only.
struct HeightRaster {
  RasterGrid grid;
  std::vector<float> z_m;           ///< NaN in unfilled voids
  std::vector<std::int32_t> point;  ///< index of the point; -1: none

  float Z(int x, int y) const { return z_m[grid.Index(x, y)]; }
};

/// Returns the heights of points on a grid; points outside are left out. Voids are filled by
/// FillVoids with shadow_cells passes.
HeightRaster MakeRaster(const RasterGrid& grid, const std::vector<Eigen::Vector3d>& points_m,
                        int shadow_cells);

/// The shift of a piece of a raster to another raster.
struct PieceShift {
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();  ///< east, north, up at the centre
  Eigen::Vector2d slope_m = Eigen::Vector2d::Zero();  ///< growth of its height per cell

  /// Returns the shift at a cell, which is counted from the centre.
  Eigen::Vector3d At(const Eigen::Vector2i& cell) const {
    return shift_m + Eigen::Vector3d(0.0, 0.0, slope_m.dot(cell.cast<double>()));
  }
};

/// Finds the shift of `a` to `b` (east, north, up, m) at which a piece of `a` fits best into `b` on
/// the same grid. The criterion is the mean square of the height differences after a plane through
/// them is removed, because misalignment tilts them. Shifts of up to `search` cells are tried; the
/// piece has `half` cells on each side of its centre. Returns nullopt if
/// - fewer than 60 % of the cells of the piece are in common;
/// - the minimum lies on the border of the search;
/// - the shift is not determined to half a cell;
/// - another shift at least 4 cells away fits nearly as well (mean square below 1.5 times the
///   best).
std::optional<PieceShift> FindShift(const HeightRaster& a, const HeightRaster& b,
                                    const Eigen::Vector2i& centre, int half, int search);

}  // namespace dn::matching_internal
