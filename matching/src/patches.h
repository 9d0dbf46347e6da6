#pragma once

#include <dn/matching/match_source.h>

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <vector>

#include "height_raster.h"
#include "register_patches.h"

namespace dn::matching_internal {

/// Returns the cells of a regular grid over the raster in which both strips have points. The first
/// ones of any number are spread over the area. side_cells: side of a grid cell in cells of the
/// raster.
std::vector<GroundCell> ChooseCells(const HeightRaster& a, const HeightRaster& b, int side_cells);

/// A square in a strip from which points are collected.
struct GatherCell {
  GroundCell cell;
  double keep_share = 1.0;  ///< fraction of its points to keep
};

/// The points in a square.
struct CellPoints {
  std::vector<double> t_s;
  std::vector<Eigen::Vector3d> x;
  std::vector<Eigen::Vector3d> p_m;
  std::vector<std::uint16_t> beam;  ///< empty if unknown

  std::size_t size() const { return t_s.size(); }

  /// Returns the points of one beam.
  CellPoints WithBeam(int number) const;
};

/// Returns the points of a strip in each square, from one pass through its files.
std::vector<CellPoints> Gather(const MatchSource& source, std::size_t strip,
                               const std::vector<GatherCell>& cells, int threads,
                               const std::function<void(std::uint64_t)>& told);

}  // namespace dn::matching_internal
