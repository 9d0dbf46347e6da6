#pragma once

#include <dn/matching/match_source.h>

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <vector>

#include "height_raster.h"

namespace dn::matching_internal {

/// A place where two strips are compared.
struct Patch {
  Eigen::Vector2i cell = Eigen::Vector2i::Zero();  ///< cell of its centre
  int half_cells = 0;
  double information = 0.0;  ///< number of points times the least variance of the slopes
};

struct PatchOptions {
  std::vector<int> half_cells;  ///< sizes to choose from, ascending
  double points_per_cell = 0.0;
  double most_points = 0.0;  ///< of a patch after thinning
  double least_information = 0.0;
  std::size_t most_patches = 0;
  int tile_cells = 0;  ///< patches are distributed over tiles of this size
};

/// Chooses places in `a` whose slopes vary enough in all directions to determine a horizontal
/// shift, and where `b` also has points. The smallest sufficient size is used, and larger patches
/// fill the remaining space. Patches do not overlap, so that no point is used twice. A wall counts
/// as a slope of 45 deg.
std::vector<Patch> ChoosePatches(const HeightRaster& a, const HeightRaster& b,
                                 const PatchOptions& options);

/// A disc in a strip from which points are collected.
struct Disc {
  Eigen::Vector2d centre_en_m = Eigen::Vector2d::Zero();
  double radius_m = 0.0;
  double keep_share = 1.0;  ///< fraction of its points to keep
};

/// The points in a disc.
struct DiscPoints {
  std::vector<double> t_s;
  std::vector<Eigen::Vector3d> x;
  std::vector<Eigen::Vector3d> p_m;

  std::size_t size() const { return t_s.size(); }
};

/// Returns the points of a strip in each disc, from one pass through its files.
std::vector<DiscPoints> Gather(const MatchSource& source, std::size_t strip,
                               const std::vector<Disc>& discs, int threads,
                               const std::function<void(std::uint64_t)>& told);

}  // namespace dn::matching_internal
