#pragma once

#include <dn/calibration/plane_flight.h>
#include <dn/matching/match.h>
#include <dn/matching/strip_planes.h>

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace dn {

/// How planes of strips are matched with each other.
struct SharePlanesOptions {
  StripPlaneOptions strips;
  /// How far the boresight may be off about each axis (AlignFlight).
  double search_rad = 5.0 * 3.14159265358979323846 / 180.0;
  /// How far it may be off after the strips were brought together: the first search of planes goes
  /// that far. Chosen.
  double misalignment_rad = 0.5 * 3.14159265358979323846 / 180.0;
  double first_angle_rad = 0.175;  ///< most between two normals, in the first search (10 deg)
  double angle_rad = 0.07;         ///< in the later ones (4 deg)
  /// Most planes of a bin: nearly level ones (below 5 deg) are one, gentle (below 15 deg) and steep
  /// ones have eight aspects each. So the ground does not drown the roofs.
  std::size_t most_of_bin = 60;
};

/// Planes that two strips or more see.
struct SharedPlanes {
  std::vector<SeenPlane> planes;
  std::vector<std::size_t> found;  ///< planes of each strip
  std::size_t matched = 0;         ///< before the bins were balanced
  double spacing_m = 0.0;
  double share = 1.0;              ///< of the overlaps that was looked at
  std::vector<MatchLevel> levels;  ///< that brought the strips together
  /// That of the last search.
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();
};

/// A plane of a strip on its trajectory.
struct PlacedPlane {
  std::vector<GaussHelmertEnd> points;
  double rms_m = 0.0;
};

/// Matches planes of strips by the alignment theta_rad: of two strips, planes that are nearest to
/// each other both ways, whose centroids are no further apart than search_m (0: than half the
/// shorter of their long sides) and whose normals differ by angle_rad at most. Matches are joined
/// over strips, the nearest first, one plane of each strip. Returns, per shared plane, indices by
/// strip; -1 where a strip has no part.
std::vector<std::vector<long>> MatchPlanes(const std::vector<std::vector<PlacedPlane>>& strips,
                                           const Eigen::Vector3d& lever_arm_b_m,
                                           const Eigen::Vector3d& theta_rad, double search_m,
                                           double angle_rad);

/// Planes that the strips of a flight share. The strips are brought together by their heights
/// (AlignFlight); planes are taken and matched by that alignment, which the plane adjustment then
/// improves, and once more by that. The noise of a plane is the rms of its parts about themselves.
///
/// flight: with its trajectory. The alignment of `source` is changed to the last one. Deterministic
/// for any number of threads. Throws as ExtractStripPlanes.
SharedPlanes FindSharedPlanes(const Flight& flight, FlightMatchSource* source,
                              const SharePlanesOptions& options);

}  // namespace dn
