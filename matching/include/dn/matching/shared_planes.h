#pragma once

#include <dn/adjustment/plane_flight.h>
#include <dn/matching/match.h>
#include <dn/matching/strip_planes.h>

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace dn {

/// Options for matching the planes of strips.
struct SharePlanesOptions {
  StripPlaneOptions strips;
  /// Largest error of the initial boresight about each axis (AlignFlight).
  double search_rad = 5.0 * 3.14159265358979323846 / 180.0;
  /// Largest error of the boresight after AlignFlight, an empirical value; it gives the radius of
  /// the first search for planes.
  double misalignment_rad = 0.5 * 3.14159265358979323846 / 180.0;
  /// Largest angle between two normals in the first search (10 deg).
  double first_angle_rad = 0.175;
  double angle_rad = 0.07;  ///< in later searches (4 deg)
  /// Largest number of planes per bin, so that planes of the ground do not outnumber those of
  /// roofs. Nearly level planes (below 5 deg) are one bin; gentle (below 15 deg) and steep planes
  /// have eight bins each, by aspect.
  std::size_t most_of_bin = 60;
};

/// Planes that two or more strips see.
struct SharedPlanes {
  std::vector<ObservedPlane> planes;
  std::vector<std::size_t> found;  ///< number of planes found in each strip
  std::size_t matched = 0;         ///< number of planes before the limit per bin
  double spacing_m = 0.0;
  double share = 1.0;              ///< fraction of the overlaps that was searched
  std::vector<MatchLevel> levels;  ///< levels of AlignFlight
  /// Boresight of the last search.
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();
};

/// A plane of a strip, as points with their trajectory poses.
struct PlacedPlane {
  std::vector<GaussHelmertEnd> points;
  double rms_m = 0.0;
};

/// Matches planes of strips with the alignment theta_rad. Planes of two strips match if each is the
/// nearest of the other. Their centroids must be at most search_m apart, and their normals must
/// differ by at most angle_rad. With search_m = 0 the limit is half the shorter of their long
/// sides. Matches are joined over the strips, the nearest first, with at most one plane per strip.
/// Returns, for each shared plane, its index in each strip; -1 for strips without it.
std::vector<std::vector<long>> MatchPlanes(const std::vector<std::vector<PlacedPlane>>& strips,
                                           const Eigen::Vector3d& lever_arm_b_m,
                                           const Eigen::Vector3d& theta_rad, double search_m,
                                           double angle_rad);

/// Finds the planes that the strips of a flight share. The strips are first aligned by their
/// heights (AlignFlight). Planes are extracted and matched with that alignment, which the plane
/// adjustment then improves; this is repeated once with the improved alignment. The noise of a
/// plane is the rms of its parts, each about its own plane.
///
/// flight: must have its trajectory. The alignment of `source` is set to the last one. The result
/// is the same for any number of threads. Throws like ExtractStripPlanes.
SharedPlanes FindSharedPlanes(const Flight& flight, FlightMatchSource* source,
                              const SharePlanesOptions& options);

}  // namespace dn
