#pragma once

#include <Eigen/Core>
#include <vector>

#include "patch_surface.h"
#include "register_patches.h"
#include "register_surface.h"

namespace dn::matching_internal {

struct MatchCellsOptions {
  GroundCell root;  ///< in strip a
  double gsd_m = 0.0;
  double smallest_half_m = 0.0;  ///< a cell with a smaller half side is not made
  bool with_surfaces = false;    ///< also registers smooth cells along their normal
};

/// A cell with its shift.
struct CellMatch {
  GroundCell cell;
  Registration registration;
};

/// A smooth cell with the distance of its surfaces.
struct SurfaceCellMatch {
  GroundCell cell;
  SurfaceRegistration registration;
};

/// The registered parts of a square.
struct CellMatches {
  std::vector<CellMatch> cells;
  std::vector<SurfaceCellMatch> surfaces;
};

/// Registers a square of the ground, then its four quarters, their quarters, and so on. It stops
/// where the expected three-dimensional sigma of a quarter is 0.25 GSD or more. Each cell starts
/// with the shift of the cell that it is part of. The quarters take the place of the cell if they
/// have at least half of its information; no point then counts twice. A cell that is mostly empty
/// is divided at once. A cell or quarter that has no
/// shift may be smooth: it then has at least the distance of its surfaces (RegisterSurface).
CellMatches MatchCells(const PatchSurface& a, const PatchSurface& b, const Eigen::Vector3d& start_m,
                       const MatchCellsOptions& options);

}  // namespace dn::matching_internal
