#include "match_cells.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "patch_differences.h"

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

/// Returns which parts of a cell have points of a patch that is shifted by shift_m.
std::vector<bool> FilledParts(const PatchSurface& patch, const GroundCell& cell,
                              const Vector3d& shift_m) {
  std::vector<bool> filled(kPartsAcross * kPartsAcross, false);
  for (const Vector3d& p_m : patch.points_m()) {
    const Vector3d at_m = p_m - shift_m;
    if (cell.Contains(at_m)) filled[static_cast<std::size_t>(PartIndex(cell, at_m))] = true;
  }
  return filled;
}

class Splitter {
 public:
  Splitter(const PatchSurface& a, const PatchSurface& b, const MatchCellsOptions& options)
      : a_(a), b_(b), options_(options) {}

  CellMatches Match(const GroundCell& cell, const Vector3d& start_m) const {
    Vector3d shift_m = start_m;
    CellMatches quarters;
    if (0.5 * cell.half_m >= options_.smallest_half_m) {
      if (IsMostlyEmpty(cell, start_m)) return MatchQuarters(cell, start_m);
      const auto rough = Register(cell, start_m, kPointsToSplit);
      if (rough) shift_m = rough->shift_m;
      if (rough &&
          QuarterSigma(*rough, OwnCovariance(*rough)) <= kMostQuarterSigma_gsd * options_.gsd_m) {
        quarters = MatchQuarters(cell, shift_m);
        if (HaveMost(quarters.cells, *rough)) return quarters;
      }
    }
    if (const auto registration = Register(cell, shift_m, kMostPoints)) {
      return {{{cell, *registration}}, {}};
    }
    return quarters.cells.empty() ? MatchSurface(cell, shift_m) : quarters;
  }

 private:
  /// Returns whether too few parts of a cell have points of both strips to register it. The cell is
  /// then at the border of the overlap, or at a small object.
  bool IsMostlyEmpty(const GroundCell& cell, const Vector3d& start_m) const {
    const std::vector<bool> in_a = FilledParts(a_, cell, Vector3d::Zero());
    const std::vector<bool> in_b = FilledParts(b_, cell, start_m);
    int filled = 0;
    for (std::size_t k = 0; k < in_a.size(); ++k) filled += in_a[k] && in_b[k] ? 1 : 0;
    return filled < kFewestParts;
  }

  std::optional<Registration> Register(const GroundCell& cell, const Vector3d& start_m,
                                       std::size_t points) const {
    return RegisterPatches(a_, b_, start_m, {cell, options_.gsd_m, points});
  }

  CellMatches MatchSurface(const GroundCell& cell, const Vector3d& start_m) const {
    if (!options_.with_surfaces) return {};
    const auto registration = RegisterSurface(a_, b_, start_m, {cell, options_.gsd_m, kMostPoints});
    if (!registration) return {};
    return {{}, {{cell, *registration}}};
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

  CellMatches MatchQuarters(const GroundCell& cell, const Vector3d& start_m) const {
    CellMatches found;
    const double half_m = 0.5 * cell.half_m;
    for (const Vector2d& corner :
         {Vector2d(-1, -1), Vector2d(1, -1), Vector2d(-1, 1), Vector2d(1, 1)}) {
      CellMatches quarter = Match({cell.centre_en_m + half_m * corner, half_m}, start_m);
      std::ranges::move(quarter.cells, std::back_inserter(found.cells));
      std::ranges::move(quarter.surfaces, std::back_inserter(found.surfaces));
    }
    return found;
  }

  const PatchSurface& a_;
  const PatchSurface& b_;
  const MatchCellsOptions& options_;
};

}  // namespace

CellMatches MatchCells(const PatchSurface& a, const PatchSurface& b, const Vector3d& start_m,
                       const MatchCellsOptions& options) {
  return Splitter(a, b, options).Match(options.root, start_m);
}

}  // namespace dn::matching_internal
