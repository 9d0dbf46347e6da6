#pragma once

#include <Eigen/Core>
#include <vector>

#include "patch_surface.h"
#include "register_patches.h"

namespace dn::matching_internal {

struct MatchCellsOptions {
  GroundCell root;  ///< in strip a
  double gsd_m = 0.0;
  double smallest_half_m = 0.0;  ///< a cell with a smaller half side is not made
};

/// A cell with its shift.
struct CellMatch {
  GroundCell cell;
  Registration registration;
};

/// Registers a square of the ground, then its four quarters, their quarters, and so on. It stops
/// where the expected three-dimensional sigma of a quarter is 0.25 GSD or more. Each cell starts
/// with the shift of the cell that it is part of. The quarters take the place of the cell if they
/// have at least half of its information; no point then counts twice.
std::vector<CellMatch> MatchCells(const PatchSurface& a, const PatchSurface& b,
                                  const Eigen::Vector3d& start_m, const MatchCellsOptions& options);

}  // namespace dn::matching_internal
