#include <Eigen/Eigenvalues>
#include <algorithm>
#include <map>
#include <utility>

#include "patches.h"

namespace dn::matching_internal {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector2i;

constexpr double kSteepestSlope = 1.0;
constexpr double kLeastFilled = 0.7;

/// Cumulative sums over the cells of a raster (number, slopes and their products), so that the sums
/// over any box need four look-ups.
class SlopeSums {
 public:
  explicit SlopeSums(const HeightRaster& raster)
      : nx_(raster.grid.nx + 1),
        sums_(raster.grid.cells() + static_cast<std::size_t>(raster.grid.nx + raster.grid.ny + 1),
              Row::Zero()) {
    for (int y = 0; y < raster.grid.ny; ++y) {
      for (int x = 0; x < raster.grid.nx; ++x) {
        Row& sum = At(x + 1, y + 1);
        sum = At(x, y + 1) + At(x + 1, y) - At(x, y) + SlopeRow(raster, x, y);
      }
    }
  }

  /// Returns the number of slopes in a box about a cell, and their covariance.
  std::pair<double, Matrix2d> Over(const Vector2i& cell, int half) const {
    const int x0 = cell.x() - half, y0 = cell.y() - half;
    const int x1 = cell.x() + half + 1, y1 = cell.y() + half + 1;
    const Row s = At(x1, y1) - At(x0, y1) - At(x1, y0) + At(x0, y0);
    const double n = s[0];
    Matrix2d C = Matrix2d::Zero();
    if (n < 1.0) return {0.0, C};
    const Vector2d mean(s[1] / n, s[2] / n);
    C << s[3], s[4], s[4], s[5];
    return {n, C / n - mean * mean.transpose()};
  }

 private:
  using Row = Eigen::Array<double, 6, 1>;

  Row& At(int x, int y) {
    return sums_[static_cast<std::size_t>(y) * static_cast<std::size_t>(nx_) +
                 static_cast<std::size_t>(x)];
  }
  const Row& At(int x, int y) const { return const_cast<SlopeSums*>(this)->At(x, y); }

  static Row SlopeRow(const HeightRaster& raster, int x, int y) {
    const RasterGrid& grid = raster.grid;
    if (x < 1 || y < 1 || x + 1 >= grid.nx || y + 1 >= grid.ny) return Row::Zero();
    const double gx = (raster.Z(x + 1, y) - raster.Z(x - 1, y)) / (2.0 * grid.cell_m);
    const double gy = (raster.Z(x, y + 1) - raster.Z(x, y - 1)) / (2.0 * grid.cell_m);
    if (std::isnan(gx) || std::isnan(gy)) return Row::Zero();
    const double steep = std::max(1.0, std::hypot(gx, gy) / kSteepestSlope);
    const double sx = gx / steep, sy = gy / steep;
    Row row;
    row << 1.0, sx, sy, sx * sx, sx * sy, sy * sy;
    return row;
  }

  int nx_;
  std::vector<Row> sums_;
};

class Chooser {
 public:
  Chooser(const HeightRaster& a, const HeightRaster& b, const PatchOptions& options)
      : a_(a), b_(b), options_(options), slopes_(a), taken_(a.grid.cells(), false) {}

  std::vector<Patch> Run() {
    std::vector<Patch> chosen;
    for (const int half : options_.half_cells) {
      for (const Patch& patch : Candidates(half)) {
        if (AnyTaken(patch)) continue;
        Take(patch);
        chosen.push_back(patch);
      }
    }
    return SharedOut(std::move(chosen));
  }

 private:
  /// Returns the candidates, the best first.
  std::vector<Patch> Candidates(int half) const {
    std::vector<Patch> found;
    const int step = std::max(1, half / 2);
    for (int y = half; y + half < a_.grid.ny; y += step) {
      for (int x = half; x + half < a_.grid.nx; x += step) {
        const Patch patch{{x, y}, half, InformationAt({x, y}, half)};
        if (patch.information >= options_.least_information && SeenByBoth(patch)) {
          found.push_back(patch);
        }
      }
    }
    std::stable_sort(found.begin(), found.end(),
                     [](const Patch& p, const Patch& q) { return p.information > q.information; });
    return found;
  }

  double InformationAt(const Vector2i& cell, int half) const {
    const auto [n, C] = slopes_.Over(cell, half);
    const double across = 2.0 * half + 1.0;
    if (n < kLeastFilled * across * across) return 0.0;
    const Eigen::SelfAdjointEigenSolver<Matrix2d> eigen(C, Eigen::EigenvaluesOnly);
    const double points = std::min(options_.most_points, n * options_.points_per_cell);
    return points * std::max(0.0, eigen.eigenvalues()[0]);
  }

  bool SeenByBoth(const Patch& patch) const {
    const int h = patch.half_cells;
    int seen = 0;
    for (const Vector2i& d :
         {Vector2i(0, 0), Vector2i(-h, -h), Vector2i(-h, h), Vector2i(h, -h), Vector2i(h, h)}) {
      const Vector2i at = patch.cell + d;
      const bool both = !std::isnan(a_.Z(at.x(), at.y())) && !std::isnan(b_.Z(at.x(), at.y()));
      seen += both ? 1 : 0;
    }
    return seen >= 4;
  }

  bool AnyTaken(const Patch& patch) const {
    for (int y = -patch.half_cells; y <= patch.half_cells; ++y) {
      for (int x = -patch.half_cells; x <= patch.half_cells; ++x) {
        if (taken_[a_.grid.Index(patch.cell.x() + x, patch.cell.y() + y)]) return true;
      }
    }
    return false;
  }

  void Take(const Patch& patch) {
    for (int y = -patch.half_cells; y <= patch.half_cells; ++y) {
      for (int x = -patch.half_cells; x <= patch.half_cells; ++x) {
        taken_[a_.grid.Index(patch.cell.x() + x, patch.cell.y() + y)] = true;
      }
    }
  }

  /// Keeps the best remaining patch of each tile in turn until there are enough.
  std::vector<Patch> SharedOut(std::vector<Patch> chosen) const {
    if (chosen.size() <= options_.most_patches) return chosen;
    std::map<std::pair<int, int>, std::vector<Patch>> tiles;
    for (const Patch& patch : chosen) {
      tiles[{patch.cell.y() / options_.tile_cells, patch.cell.x() / options_.tile_cells}].push_back(
          patch);
    }
    for (auto& [tile, patches] : tiles) {
      std::stable_sort(patches.begin(), patches.end(), [](const Patch& p, const Patch& q) {
        return p.information > q.information;
      });
    }
    std::vector<Patch> kept;
    for (std::size_t turn = 0; kept.size() < options_.most_patches; ++turn) {
      for (const auto& [tile, patches] : tiles) {
        if (turn < patches.size() && kept.size() < options_.most_patches) {
          kept.push_back(patches[turn]);
        }
      }
    }
    return kept;
  }

  const HeightRaster& a_;
  const HeightRaster& b_;
  const PatchOptions& options_;
  SlopeSums slopes_;
  std::vector<bool> taken_;
};

}  // namespace

std::vector<Patch> ChoosePatches(const HeightRaster& a, const HeightRaster& b,
                                 const PatchOptions& options) {
  return Chooser(a, b, options).Run();
}

}  // namespace dn::matching_internal
