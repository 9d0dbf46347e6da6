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

/// How planes are taken from strips.
struct StripPlaneOptions {
  /// Distance of the points; absent, or where the points are further apart, by their density.
  std::optional<double> gsd_m = {};
  /// Points of a strip that are looked at. Where the overlaps hold more, squares of the ground are
  /// left out evenly: memory and time are bounded by it, not by the strip.
  std::size_t most_points = 3'000'000;
  std::size_t most_points_of_plane = 150;  ///< of a strip; evenly chosen of all
  double tile_m = 100.0;                   ///< side of the squares
  int threads = 1;                         ///< the result does not depend on it
  /// Called with the stage; may throw to end the work.
  std::function<void(const std::string& stage)> progress = {};
};

/// A plane as one strip sees it: points, and what they are by the present alignment.
struct StripPlane {
  std::vector<double> t_s;
  std::vector<Eigen::Vector3d> u_s;  ///< laser vectors in the sensor frame, m
  double rms_m = 0.0;                ///< of all its points about it
};

/// The planes of a flight's strips.
struct StripPlanes {
  std::vector<std::vector<StripPlane>> strips;
  double spacing_m = 0.0;  ///< of the points, after thinning
  double share = 1.0;      ///< of the overlaps that was looked at
};

/// Planes of the strips where at least two of them cover the ground (GrowPlanarRegions on squares of
/// the ground that all strips share, thinned to one point per spacing). The strips are read twice.
/// Throws InvalidInput as MatchSource::Read, RankDeficient where no two strips overlap.
StripPlanes ExtractStripPlanes(const MatchSource& source, const StripPlaneOptions& options);

}  // namespace dn
