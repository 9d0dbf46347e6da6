#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace dn::internal {

/// Cells of a horizontal grid in m. Cell (x, y) has its centre at origin + cell (x + 1/2, y + 1/2).
struct RasterGrid {
  Eigen::Vector2d origin_en_m = Eigen::Vector2d::Zero();
  double cell_m = 1.0;
  int nx = 0, ny = 0;

  std::size_t cells() const { return static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny); }
  bool Has(int x, int y) const { return x >= 0 && y >= 0 && x < nx && y < ny; }
  std::size_t Index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(nx) + static_cast<std::size_t>(x);
  }
  Eigen::Vector2i CellOf(const Eigen::Vector2d& en_m) const {
    return ((en_m - origin_en_m) / cell_m).array().floor().cast<int>();
  }
  Eigen::Vector2d Centre(int x, int y) const {
    return origin_en_m + cell_m * (Eigen::Vector2d(x, y) + Eigen::Vector2d::Constant(0.5));
  }
};

/// Mean heights of the points in each cell, and one of those points.
struct HeightRaster {
  RasterGrid grid;
  std::vector<float> z_m;           ///< NaN where there is no point, nor enough neighbours
  std::vector<std::int32_t> point;  ///< index of the point nearest to the cell's centre; -1: none

  float Z(int x, int y) const { return z_m[grid.Index(x, y)]; }
};

/// Heights of points on a grid; points outside are left out. A cell without points between at least
/// five with some gets their mean.
HeightRaster MakeRaster(const RasterGrid& grid, const std::vector<Eigen::Vector3d>& points_m);

/// How a piece of one raster lies in another.
struct PatchShift {
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();  ///< of a to b: east, north, up
  double sigma_m = 0.0;       ///< of the horizontal shift in its weakest direction
  double rms_m = 0.0;         ///< of the heights' differences
  double second_ratio = 0.0;  ///< mean square of the next best shift by that of the best
};

/// Where a piece of `a` fits best into `b`, on the same grid: the mean square of what is left of the
/// differences of height after their plane (which misalignment tilts) is removed is least. Shifts of
/// up to `search` cells; the piece has `half` cells on each side of its centre. None where fewer than
/// 60 % of the piece's cells are in common, the least lies on the border of the search, the shift is
/// not determined to half a cell, or another one 4 cells away or more fits nearly as well (mean
/// square below 1.5 times the best).
std::optional<PatchShift> FindShift(const HeightRaster& a, const HeightRaster& b,
                                    const Eigen::Vector2i& centre, int half, int search);

}  // namespace dn::internal
