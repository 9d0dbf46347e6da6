#pragma once

#include <dn/matching/match_source.h>
#include <dn/matching/planar_regions.h>

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// Options for extracting planes from strips.
struct StripPlaneOptions {
  /// Spacing of the points. If absent, or if the points are further apart, the spacing follows from
  /// their density.
  std::optional<double> gsd_m = {};
  /// Limit for the number of points of a strip in the overlaps. If there are more, squares of the
  /// ground are left out evenly. Memory and time then do not depend on the size of the strip.
  std::size_t most_points = 3'000'000;
  /// Largest number per strip, evenly chosen from all its points.
  std::size_t most_points_of_plane = 150;
  double tile_m = 100.0;  ///< side of the ground squares
  int threads = 1;        ///< the result does not depend on it
  /// Called with the stage; may throw to stop the work.
  std::function<void(const std::string& stage)> progress = {};
};

/// A plane as one strip sees it: points that lie on a plane with the present alignment.
struct StripPlane {
  std::vector<double> t_s;
  std::vector<Eigen::Vector3d> u_s;  ///< laser vectors in the sensor frame, m
  std::vector<int> beam;             ///< number of the laser beam of each point, or kNoBeam
  double rms_m = 0.0;                ///< rms of all its points about the plane
};

/// The planes of the strips of a flight.
struct StripPlanes {
  std::vector<std::vector<StripPlane>> strips;
  double spacing_m = 0.0;  ///< spacing of the points after thinning
  double share = 1.0;      ///< fraction of the overlaps that was searched
};

/// Extracts the planes of the strips where at least two strips cover the ground. GrowPlanarRegions
/// is applied to ground squares common to all strips, thinned to one point per spacing. The strips
/// are read twice. Throws InvalidInput like MatchSource::Read, RankDeficient if no two strips
/// overlap.
StripPlanes ExtractStripPlanes(const MatchSource& source, const StripPlaneOptions& options);

}  // namespace dn
