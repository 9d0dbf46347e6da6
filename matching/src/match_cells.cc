#include "match_cells.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

namespace dn::matching_internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kMostQuarterSigma_gsd = 0.25;  // three-dimensional
constexpr double kLeastInformation = 0.5;       // of the quarters, as a share of their cell's
constexpr std::size_t kPointsToSplit = 600;     // of each strip, to decide whether to split a cell
constexpr std::size_t kMostPoints = 8000;

/// Covariance of a shift with the variance ratio of its own cell.
Matrix3d OwnCovariance(const Registration& registration) {
  return registration.Covariance(std::max(1.0, registration.variance_ratio));
}

/// Returns the expected three-dimensional sigma of a quarter of a cell.
double QuarterSigma(const Registration& cell, const Matrix3d& covariance_m2) {
  const double share = static_cast<double>(cell.used) / static_cast<double>(cell.points);
  return std::sqrt(4.0 * share * covariance_m2.trace());
}

class Splitter {
 public:
  Splitter(const PatchSurface& a, const PatchSurface& b, const MatchCellsOptions& options)
      : a_(a), b_(b), options_(options) {}

  std::vector<CellMatch> Match(const GroundCell& cell, const Vector3d& start_m) const {
    Vector3d shift_m = start_m;
    std::vector<CellMatch> quarters;
    if (0.5 * cell.half_m >= options_.smallest_half_m) {
      const auto rough = Register(cell, start_m, kPointsToSplit);
      if (rough) shift_m = rough->shift_m;
      if (rough &&
          QuarterSigma(*rough, OwnCovariance(*rough)) <= kMostQuarterSigma_gsd * options_.gsd_m) {
        quarters = MatchQuarters(cell, shift_m);
        if (HaveMost(quarters, *rough)) return quarters;
      }
    }
    const auto registration = Register(cell, shift_m, kMostPoints);
    if (!registration) return quarters;
    return {{cell, *registration}};
  }

 private:
  std::optional<Registration> Register(const GroundCell& cell, const Vector3d& start_m,
                                       std::size_t points) const {
    return RegisterPatches(a_, b_, start_m, {cell, options_.gsd_m, points});
  }

  /// Returns whether the quarters have at least half of the information of their cell.
  static bool HaveMost(const std::vector<CellMatch>& quarters, const Registration& cell) {
    Matrix3d information = Matrix3d::Zero();
    for (const CellMatch& quarter : quarters) {
      information += OwnCovariance(quarter.registration).inverse();
    }
    const double share = static_cast<double>(cell.used) / static_cast<double>(cell.points);
    return (share * OwnCovariance(cell) * information).trace() >= 3.0 * kLeastInformation;
  }

  std::vector<CellMatch> MatchQuarters(const GroundCell& cell, const Vector3d& start_m) const {
    std::vector<CellMatch> found;
    const double half_m = 0.5 * cell.half_m;
    for (const Vector2d& corner :
         {Vector2d(-1, -1), Vector2d(1, -1), Vector2d(-1, 1), Vector2d(1, 1)}) {
      std::ranges::move(Match({cell.centre_en_m + half_m * corner, half_m}, start_m),
                        std::back_inserter(found));
    }
    return found;
  }

  const PatchSurface& a_;
  const PatchSurface& b_;
  const MatchCellsOptions& options_;
};

}  // namespace

std::vector<CellMatch> MatchCells(const PatchSurface& a, const PatchSurface& b,
                                  const Vector3d& start_m, const MatchCellsOptions& options) {
  return Splitter(a, b, options).Match(options.root, start_m);
}

}  // namespace dn::matching_internal
