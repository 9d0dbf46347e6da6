#include "height_raster.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>

#include "fill_voids.h"

namespace dn::matching_internal {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector2i;
using Eigen::Vector3d;

constexpr int kMostSamplesAcross = 17;
constexpr double kLeastInCommon = 0.6;
constexpr double kLeastSecondRatio = 1.5;
constexpr int kApart = 4;
constexpr double kMostSigmaCells = 0.5;
// Neighbouring heights are not independent: a quarter of them is counted (empirical).
constexpr double kIndependentShare = 0.25;

/// A cell of the piece: its offset from the centre in cells, and its height.
struct Sample {
  int x, y;
  float z_m;
};

/// The residuals of the differences b - a at one shift.
struct Difference {
  double mean_square_m2 = std::numeric_limits<double>::infinity();
  /// The plane through the differences: its value at the centre, m, and its slopes, m per cell.
  Vector3d plane = Vector3d::Zero();
};

Difference DifferenceAt(const HeightRaster& b, const std::vector<Sample>& piece,
                        const Vector2i& centre) {
  Matrix3d N = Matrix3d::Zero();
  Vector3d h = Vector3d::Zero();
  double dd = 0.0;
  for (const Sample& s : piece) {
    const int x = centre.x() + s.x, y = centre.y() + s.y;
    if (!b.grid.Has(x, y)) continue;
    const float z = b.Z(x, y);
    if (std::isnan(z)) continue;
    const double d = z - s.z_m;
    N(0, 0) += 1.0;
    N(0, 1) += s.x;
    N(0, 2) += s.y;
    N(1, 1) += s.x * s.x;
    N(1, 2) += s.x * s.y;
    N(2, 2) += s.y * s.y;
    h += Vector3d(d, d * s.x, d * s.y);
    dd += d * d;
  }
  Difference out;
  if (N(0, 0) < kLeastInCommon * static_cast<double>(piece.size())) return out;
  const Eigen::LDLT<Matrix3d> ldlt(N.selfadjointView<Eigen::Upper>());
  const Vector3d plane = ldlt.solve(h);
  out.mean_square_m2 = std::max(0.0, dd - plane.dot(h)) / N(0, 0);
  out.plane = plane;
  return out;
}

std::vector<Sample> SamplePiece(const HeightRaster& a, const Vector2i& centre, int half) {
  const int step = std::max(1, (2 * half + 1 + kMostSamplesAcross - 1) / kMostSamplesAcross);
  std::vector<Sample> piece;
  std::size_t cells = 0;
  for (int y = -half; y <= half; y += step) {
    for (int x = -half; x <= half; x += step) {
      ++cells;
      if (!a.grid.Has(centre.x() + x, centre.y() + y)) continue;
      const float z = a.Z(centre.x() + x, centre.y() + y);
      if (!std::isnan(z)) piece.push_back({x, y, z});
    }
  }
  if (static_cast<double>(piece.size()) < kLeastInCommon * static_cast<double>(cells))
    piece.clear();
  return piece;
}

}  // namespace

HeightRaster MakeRaster(const RasterGrid& grid, const std::vector<Vector3d>& points_m,
                        int shadow_cells) {
  HeightRaster raster;
  raster.grid = grid;
  raster.z_m.assign(grid.cells(), std::numeric_limits<float>::quiet_NaN());
  raster.point.assign(grid.cells(), -1);
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    const Vector2i cell = grid.CellIndex(points_m[i].head<2>());
    if (!grid.Has(cell.x(), cell.y())) continue;
    const std::size_t k = grid.Index(cell.x(), cell.y());
    const auto z_m = static_cast<float>(points_m[i].z());
    if (raster.point[k] >= 0 && raster.z_m[k] >= z_m) continue;
    raster.z_m[k] = z_m;
    raster.point[k] = static_cast<std::int32_t>(i);
  }
  FillVoids(grid.nx, grid.ny, shadow_cells, &raster.z_m);
  return raster;
}

std::optional<PieceShift> FindShift(const HeightRaster& a, const HeightRaster& b,
                                    const Vector2i& centre, int half, int search) {
  const std::vector<Sample> piece = SamplePiece(a, centre, half);
  if (piece.empty()) return std::nullopt;
  const std::size_t across = 2 * static_cast<std::size_t>(search) + 1;
  std::vector<Difference> all(across * across);
  const auto at = [&](int x, int y) -> Difference& {
    return all[static_cast<std::size_t>(y + search) * across +
               static_cast<std::size_t>(x + search)];
  };
  Vector2i best(0, 0);
  for (int y = -search; y <= search; ++y) {
    for (int x = -search; x <= search; ++x) {
      at(x, y) = DifferenceAt(b, piece, centre + Vector2i(x, y));
      if (at(x, y).mean_square_m2 < at(best.x(), best.y()).mean_square_m2) best = {x, y};
    }
  }
  const Difference& least = at(best.x(), best.y());
  if (!std::isfinite(least.mean_square_m2)) return std::nullopt;
  if (best.cwiseAbs().maxCoeff() >= search) return std::nullopt;
  double second = std::numeric_limits<double>::infinity();
  for (int y = -search; y <= search; ++y) {
    for (int x = -search; x <= search; ++x) {
      if ((Vector2i(x, y) - best).cwiseAbs().maxCoeff() < kApart) continue;
      second = std::min(second, at(x, y).mean_square_m2);
    }
  }
  const double floor_m2 = 1e-12;
  const double second_ratio = second / std::max(least.mean_square_m2, floor_m2);
  if (!(second_ratio >= kLeastSecondRatio)) return std::nullopt;

  const auto f = [&](int x, int y) { return at(best.x() + x, best.y() + y).mean_square_m2; };
  const Vector2d g(0.5 * (f(1, 0) - f(-1, 0)), 0.5 * (f(0, 1) - f(0, -1)));
  Matrix2d H;
  H(0, 0) = f(1, 0) - 2.0 * f(0, 0) + f(-1, 0);
  H(1, 1) = f(0, 1) - 2.0 * f(0, 0) + f(0, -1);
  H(0, 1) = H(1, 0) = 0.25 * (f(1, 1) - f(1, -1) - f(-1, 1) + f(-1, -1));
  if (!H.allFinite()) return std::nullopt;
  const Eigen::SelfAdjointEigenSolver<Matrix2d> eigen(H);
  if (!(eigen.eigenvalues()[0] > 0.0)) return std::nullopt;
  const Vector2d rest = -H.ldlt().solve(g);
  if (rest.cwiseAbs().maxCoeff() > 1.0) return std::nullopt;
  const double independent = kIndependentShare * static_cast<double>(piece.size());
  // The mean square of n independent differences is m(s) = m0 + s^T H s / 2. The covariance is
  // therefore C = 2 m0 / n H^-1.
  const double sigma_cells =
      std::sqrt(2.0 * least.mean_square_m2 / independent / eigen.eigenvalues()[0]);
  if (sigma_cells > kMostSigmaCells) return std::nullopt;
  PieceShift shift;
  shift.shift_m << a.grid.cell_m * (best.cast<double>() + rest), least.plane[0];
  shift.slope_m = least.plane.tail<2>();
  return shift;
}

}  // namespace dn::matching_internal
