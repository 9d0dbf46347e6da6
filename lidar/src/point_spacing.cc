#include <dn/lidar/point_spacing.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace dn {
namespace {

constexpr double kFirstCell_m = 1.0;
constexpr double kPointsPerCell = 30.0;
constexpr int kMostRounds = 8;

/// Returns the number of cells of a horizontal grid that contain points.
std::size_t CellsWithPoints(const std::vector<Eigen::Vector3d>& p_m, double cell_m) {
  std::vector<std::pair<double, double>> cells;
  cells.reserve(p_m.size());
  for (const Eigen::Vector3d& p : p_m) {
    cells.emplace_back(std::floor(p.x() / cell_m), std::floor(p.y() / cell_m));
  }
  std::sort(cells.begin(), cells.end());
  return static_cast<std::size_t>(std::unique(cells.begin(), cells.end()) - cells.begin());
}

}  // namespace

std::optional<double> PointSpacing(const std::vector<Eigen::Vector3d>& p_m, double points) {
  if (p_m.empty()) return std::nullopt;
  double cell_m = kFirstCell_m;
  for (int round = 0; round < kMostRounds; ++round, cell_m *= 2.0) {
    const auto cells = static_cast<double>(CellsWithPoints(p_m, cell_m));
    const double density_m2 = points / (cells * cell_m * cell_m);
    if (density_m2 * cell_m * cell_m >= kPointsPerCell) return 1.0 / std::sqrt(density_m2);
  }
  return std::nullopt;
}

}  // namespace dn
