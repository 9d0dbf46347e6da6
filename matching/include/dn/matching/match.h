#pragma once

#include <dn/lidar/pairs.h>
#include <dn/lidar/swath.h>
#include <dn/matching/match_source.h>

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// How strips are matched.
struct MatchOptions {
  std::optional<double>
      gsd_m;  ///< ground sampling distance; absent: from the density of the points
  /// How far the strips may be apart before. Of a flight: the boresight may be off by this angle
  /// about each axis.
  double search_rad = 5.0 * 3.14159265358979323846 / 180.0;
  double search_m = 10.0;         ///< of bare strips
  std::size_t most_pairs = 3000;  ///< of a strip pair
  /// Half the side of the patches that are compared, in ground sampling distances. Where they leave
  /// room, patches of twice that. Smaller ones give more pairs, of more noise.
  double patch_gsd = 24.0;
  Eigen::Vector3d sigma_ned_m = Eigen::Vector3d(0.03, 0.03, 0.05);  ///< of the trajectory
  Eigen::Vector3d sigma_rph_rad = Eigen::Vector3d(5e-5, 5e-5, 9e-5);
  std::uint64_t seed = 0;
  int threads = 1;
  /// Called with the stage and what is done of it; may throw to end the work.
  std::function<void(const std::string& stage, const std::string& done)> progress = {};
};

/// A point of strip j, and the place on strip i that is the same point of the ground: `i` is not a
/// measured point but one moved to it from the nearest measured one, at whose epoch it counts.
struct MatchedPair {
  LidarPair pair;                                   ///< vectors as of RawPoints::x
  Eigen::Vector3d p_i_m = Eigen::Vector3d::Zero();  ///< before: by the alignment that was given
  Eigen::Vector3d p_j_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d after_m = Eigen::Vector3d::Zero();  ///< p_i - p_j by the alignment of all pairs
  double radius_m = 0.0;                              ///< of the patches that were compared

  Eigen::Vector3d before_m() const { return p_i_m - p_j_m; }
};

/// The pairs of two strips, and how many were left after each stage.
struct StripPairMatch {
  std::size_t i = 0, j = 0;    ///< strips
  double overlap_m2 = 0.0;     ///< of ground that both have points of
  std::size_t candidates = 0;  ///< places with enough shape
  std::size_t found = 0;       ///< with one clear shift between the rasters
  std::size_t registered = 0;  ///< with a shift between the points as good as is asked
  /// By which the covariances are larger for neighbours to agree as they do, at least 1.
  double variance_factor = 1.0;
  std::vector<MatchedPair> pairs;  ///< that agree with their neighbours
};

/// A stage from coarse to fine.
struct MatchLevel {
  double cell_m = 0.0, search_m = 0.0;
  std::size_t places = 0, found = 0, agreeing = 0;
  double rms_m = 0.0;  ///< of the agreeing ones after the alignment
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();  ///< after it; of a flight
};

/// Correspondences between strips.
struct MatchResult {
  double gsd_m = 0.0;
  std::vector<StripCounts> strips;
  std::vector<Swath> swaths;  ///< without the path for bare strips
  std::vector<MatchLevel> levels;
  std::vector<StripPairMatch> strip_pairs;
  /// Of a flight: that of the pairs.
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();
  /// Of the covariances, variance by the scatter within patches to that of independent distances.
  double variance_factor = 1.0;

  std::size_t pairs() const;
};

/// Point-to-point correspondences from the overlaps of all strips of a flight, from coarse to fine:
///
/// 1. Rasters of heights; where pieces of one lie in the other (least squares of the differences),
///    at cells of a sixteenth of the search radius. The boresight that most of the shifts agree
///    with, by an adjustment of the Gauss-Helmert kind, brings the strips together; the search
///    radius shrinks, and so on down to 18 GSD.
/// 2. Places with slopes in all directions, of 24 GSD in radius, larger ones where these leave room; a raster search about each.
/// 3. The points themselves: registration of the two patches, both ways, with its covariance.
/// 4. What contradicts its neighbours is left out.
///
/// The alignment of `source` is changed to the one found. Deterministic for any number of threads.
/// Throws InvalidInput as MatchSource::Read, where there are fewer than two strips, and where no two
/// of them overlap; InvalidConfig for a gsd_m below a tenth of the distance between the points.
MatchResult MatchFlight(FlightMatchSource* source, const MatchOptions& options);

/// The first of these stages alone: turns the boresight of `source` until the strips lie together to
/// 18 GSD, and leaves it where no shift is clear. Throws as MatchFlight, but for overlap.
std::vector<MatchLevel> AlignFlight(FlightMatchSource* source, const MatchOptions& options);

/// The same of two or more strips without a trajectory: a shift of each strip takes the place of
/// the boresight.
MatchResult MatchBareStrips(BareMatchSource* source, const MatchOptions& options);

}  // namespace dn
