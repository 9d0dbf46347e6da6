#include <dn/error.h>
#include <dn/lidar/strip_surface.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace dn {
namespace {

constexpr double kFewestPoints = 6.0;
constexpr double kRoughestM = 0.1;
const double kSteepest = std::tan(10.0 / 180.0 * std::numbers::pi);
// Points that fill a cell evenly have a standard deviation of 0.29 cells in each direction.
constexpr double kLeastSpread = 0.15;  // in cells

}  // namespace

std::int32_t CellNumber(double x_m, double cell_m) {
  using Limits = std::numeric_limits<std::int32_t>;
  return static_cast<std::int32_t>(
      std::clamp<double>(std::floor(x_m / cell_m), Limits::min(), Limits::max()));
}

std::uint64_t CellKey(const Eigen::Vector2d& en_m, double cell_m) {
  const auto east = static_cast<std::uint32_t>(CellNumber(en_m.x(), cell_m));
  const auto north = static_cast<std::uint32_t>(CellNumber(en_m.y(), cell_m));
  return std::uint64_t{north} << 32U | east;
}

Eigen::Vector2d CellCentre(std::uint64_t key, double cell_m) {
  const auto east = static_cast<std::int32_t>(key & 0xffffffffU);
  const auto north = static_cast<std::int32_t>(key >> 32U);
  return {(east + 0.5) * cell_m, (north + 0.5) * cell_m};
}

std::optional<double> FlatSurface::At(const Eigen::Vector2d& en_m) const {
  const auto cell = up_m.find(CellKey(en_m, cell_m));
  return cell == up_m.end() ? std::nullopt : std::optional(cell->second);
}

void StripSurface::Add(const Eigen::Vector3d& p_m) {
  const std::uint64_t key = CellKey(p_m.head<2>(), cell_m_);
  const auto [cell, is_new] = cells_.try_emplace(key);
  Sums& sums = cell->second;
  if (is_new) sums.first_up_m = static_cast<float>(p_m.z());
  const Eigen::Vector2f at = (p_m.head<2>() - CellCentre(key, cell_m_)).cast<float>();
  const auto up = static_cast<float>(p_m.z() - double{sums.first_up_m});
  sums.points += 1.0F;
  sums.east += at.x();
  sums.north += at.y();
  sums.up += up;
  sums.east2 += at.x() * at.x();
  sums.east_north += at.x() * at.y();
  sums.north2 += at.y() * at.y();
  sums.east_up += at.x() * up;
  sums.north_up += at.y() * up;
  sums.up2 += up * up;
}

std::optional<double> StripSurface::FlatHeight(const Sums& sums) const {
  const double n = sums.points;
  if (n < kFewestPoints) return std::nullopt;
  Eigen::Matrix3d N;  // of (1, east, north)
  N << n, sums.east, sums.north, sums.east, sums.east2, sums.east_north, sums.north,
      sums.east_north, sums.north2;
  const Eigen::Vector3d b(sums.up, sums.east_up, sums.north_up);
  const Eigen::Vector2d mean_m = N.block<2, 1>(1, 0) / n;
  const Eigen::Matrix2d spread_m2 = N.block<2, 2>(1, 1) / n - mean_m * mean_m.transpose();
  const double least_m2 = std::pow(kLeastSpread * cell_m_, 2);
  // The smaller eigenvalue exceeds the bound if this matrix is positive definite.
  const Eigen::Matrix2d above = spread_m2 - least_m2 * Eigen::Matrix2d::Identity();
  if (above(0, 0) <= 0.0 || above.determinant() <= 0.0) return std::nullopt;
  const Eigen::Vector3d plane = N.ldlt().solve(b);
  const double variance_m2 = (sums.up2 - plane.dot(b)) / (n - 3.0);
  if (variance_m2 > kRoughestM * kRoughestM || plane.tail<2>().norm() > kSteepest) {
    return std::nullopt;
  }
  return double{sums.first_up_m} + plane[0];
}

FlatSurface StripSurface::Flat() const {
  FlatSurface flat{cell_m_, {}};
  for (const auto& [key, sums] : cells_) {
    if (const auto up_m = FlatHeight(sums)) flat.up_m.emplace(key, *up_m);
  }
  return flat;
}

std::vector<SurfaceDifference> SurfaceDifferences(const FlatSurface& first,
                                                  const FlatSurface& second) {
  if (first.cell_m != second.cell_m) throw InvalidConfig("surfaces with cells of different sizes");
  std::vector<SurfaceDifference> differences;
  for (const auto& [key, up_m] : first.up_m) {
    const auto other = second.up_m.find(key);
    if (other != second.up_m.end()) differences.push_back({key, other->second - up_m});
  }
  std::ranges::sort(differences, {}, &SurfaceDifference::cell);
  return differences;
}

}  // namespace dn
