#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "patches.h"

namespace dn::matching_internal {
namespace {

constexpr int kFewestInCommon = 16;  // raster cells of 3 GSD: the smallest cell that is matched

int CountInCommon(const HeightRaster& a, const HeightRaster& b, int x0, int y0, int side) {
  int count = 0;
  for (int y = y0; y < std::min(y0 + side, a.grid.ny); ++y) {
    for (int x = x0; x < std::min(x0 + side, a.grid.nx); ++x) {
      if (!std::isnan(a.Z(x, y)) && !std::isnan(b.Z(x, y))) ++count;
    }
  }
  return count;
}

}  // namespace

std::vector<GroundCell> ChooseCells(const HeightRaster& a, const HeightRaster& b, int side_cells) {
  std::vector<GroundCell> found;
  const double half_m = 0.5 * side_cells * a.grid.cell_m;
  for (int y = 0; y < a.grid.ny; y += side_cells) {
    for (int x = 0; x < a.grid.nx; x += side_cells) {
      if (CountInCommon(a, b, x, y, side_cells) < kFewestInCommon) continue;
      const Eigen::Vector2d corner_m = a.grid.origin_en_m + a.grid.cell_m * Eigen::Vector2d(x, y);
      found.push_back({corner_m + Eigen::Vector2d::Constant(half_m), half_m});
    }
  }
  // Multiples of the golden ratio are spread evenly, however many are taken.
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t k = 0; k < found.size(); ++k) {
    const double multiple = (std::numbers::phi - 1.0) * static_cast<double>(k);
    order.emplace_back(multiple - std::floor(multiple), k);
  }
  std::sort(order.begin(), order.end());
  std::vector<GroundCell> spread;
  for (const auto& [fraction, k] : order) spread.push_back(found[k]);
  return spread;
}

}  // namespace dn::matching_internal
