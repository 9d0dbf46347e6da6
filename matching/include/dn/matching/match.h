#pragma once

#include <dn/lidar/pairs.h>
#include <dn/lidar/surface_pairs.h>
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

/// Options of the matching of strips.
struct MatchOptions {
  /// Ground sampling distance; absent: derived from the density of the points.
  std::optional<double> gsd_m;
  /// Search radius for a flight: largest error of the initial boresight about each axis.
  double search_rad = 5.0 * 3.14159265358979323846 / 180.0;
  double search_m = 10.0;         ///< search radius for bare strips
  std::size_t most_pairs = 3000;  ///< largest number of pairs of a strip pair
  /// Half the side of the smallest cells, in ground sampling distances. Cells of 96 GSD are divided
  /// as long as the quarters are accurate enough.
  double patch_gsd = 6.0;
  /// Position sigmas of the trajectory.
  Eigen::Vector3d sigma_ned_m = Eigen::Vector3d(0.03, 0.03, 0.05);
  Eigen::Vector3d sigma_rph_rad = Eigen::Vector3d(5e-5, 5e-5, 9e-5);
  /// Number of beams of the scanner. With several beams, each pair is registered from the points of
  /// one beam on each side. A ground sampling distance is then increased to that of one beam.
  int beams = 1;
  /// Whether a flight without two strips that overlap is an error; otherwise it has no pairs, and
  /// keeps its boresight.
  bool must_overlap = true;
  std::uint64_t seed = 0;
  int threads = 1;
  /// Called with the stage and its progress; may throw to stop the work.
  std::function<void(const std::string& stage, const std::string& done)> progress = {};
};

/// A point of strip j and the corresponding place on strip i. `i` is not a measured point: it is
/// the nearest measured point moved to this place, and has the epoch of the measured point.
struct MatchedPair {
  LidarPair pair;                                   ///< vectors like RawPoints::x
  Eigen::Vector3d p_i_m = Eigen::Vector3d::Zero();  ///< position with the initial alignment
  Eigen::Vector3d p_j_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d after_m = Eigen::Vector3d::Zero();  ///< p_i - p_j with the alignment of all pairs
  double radius_m = 0.0;                              ///< half the side of the cell
  /// Shift of the pair per unit shift of the returns of plants, edges and other volumes.
  Eigen::Matrix3d volumetric_share = Eigen::Matrix3d::Zero();

  Eigen::Vector3d before_m() const { return p_i_m - p_j_m; }
};

/// Points of both strips on one smooth cell of the ground, whose horizontal shift is not known. The
/// point of strip j is a measured one, as in MatchedPair.
struct MatchedSurface {
  SurfacePair pair;
  Eigen::Vector3d p_j_m = Eigen::Vector3d::Zero();  ///< position with the initial alignment
  /// n^T (p_i - p_j) with the initial alignment, and with that of all pairs.
  double before_m = 0.0, after_m = 0.0;
  double radius_m = 0.0;  ///< half the side of the cell
};

/// The pairs of two strips and their number after each stage.
struct StripPairMatch {
  std::size_t i = 0, j = 0;    ///< indices of the strips
  double overlap_m2 = 0.0;     ///< area of the ground with points of both strips
  std::size_t candidates = 0;  ///< places that both strips cover
  std::size_t found = 0;       ///< places with a unique shift between the rasters
  std::size_t registered = 0;  ///< cells with a sufficiently accurate shift between the points
  /// Variance inflation (>= 1) that makes neighbouring matches consistent.
  double variance_factor = 1.0;
  std::vector<MatchedPair> pairs;  ///< pairs that agree with their neighbours
  /// Variance inflation (>= 1) that makes neighbouring surfaces consistent.
  double surface_variance_factor = 1.0;
  std::vector<MatchedSurface> surfaces;  ///< those that agree with their neighbours
};

/// Apparent range offset of plants: two strips see a plant from different sides, and their returns
/// differ as if ranges to plants had this offset.
struct PlantRangeOffset {
  double offset_m = 0.0;
  double sigma_m = 0.0;
  double share = 0.0;  ///< mean horizontal volumetric share of the pairs
};

/// A level of the search from coarse to fine.
struct MatchLevel {
  double cell_m = 0.0, search_m = 0.0;
  std::size_t places = 0, found = 0, agreeing = 0;
  double rms_m = 0.0;  ///< of the agreeing places after the alignment
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();  ///< after the alignment; for a flight
};

/// Correspondences between strips.
struct MatchResult {
  double gsd_m = 0.0;
  std::vector<StripCounts> strips;
  std::vector<Swath> swaths;  ///< bare strips have no flight path
  std::vector<MatchLevel> levels;
  std::vector<StripPairMatch> strip_pairs;
  /// For a flight: the boresight of the pairs.
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();
  /// Variance inflation (>= 1) of all covariances: the variance from the scatter within patches,
  /// divided by the variance for independent distances.
  double variance_factor = 1.0;
  double surface_variance_factor = 1.0;  ///< the same, of the surfaces
  /// For a flight with pairs. Their positions are corrected for it.
  std::optional<PlantRangeOffset> plant_offset = {};

  std::size_t pairs() const;
};

/// Finds point-to-point correspondences in the overlaps of all strips of a flight, from coarse to
/// fine:
///
/// 1. Height rasters: pieces of one raster are located in the other by least squares of the height
///    differences, at first with cells of a sixteenth of the search radius. The boresight with
///    which most shifts agree, from a Gauss-Helmert adjustment, brings the strips together. The
///    search radius is then reduced, down to 18 GSD.
/// 2. A raster search at places 48 GSD apart.
/// 3. The points themselves: registration of ground cells in both directions, with its covariance.
///    Cells of 96 GSD are divided into quarters as long as the quarters are accurate enough. Smooth
///    cells, whose horizontal shift is not known, become surfaces, for a scanner with one beam.
/// 4. Matches that contradict their neighbours are left out.
/// 5. The range offset of plants is estimated from all pairs, with a prior of half a GSD, and the
///    pairs are corrected for it. Their covariances contain its sigma.
///
/// The boresight of the rasters leaves the strips tilted against each other. Of a flight, steps 2
/// to 4 therefore first match 32 large cells of each strip pair. They are repeated once if the
/// boresight then still turns by more than 1e-4 rad.
///
/// The alignment of `source` is set to the result. The result is the same for any number of
/// threads. Throws InvalidInput like MatchSource::Read, for fewer than two strips, and if no two
/// strips overlap. Throws InvalidConfig if gsd_m is below a tenth of the distance between the
/// points.
MatchResult MatchFlight(FlightMatchSource* source, const MatchOptions& options);

/// Runs only the first of these stages: turns the boresight of `source` until the strips agree to
/// 18 GSD. The boresight is unchanged if no shift is unique. Throws like MatchFlight, except for
/// missing overlap.
std::vector<MatchLevel> AlignFlight(FlightMatchSource* source, const MatchOptions& options);

/// Finds the correspondences of two or more strips without a trajectory: a shift of each strip
/// takes the place of the boresight.
MatchResult MatchBareStrips(BareMatchSource* source, const MatchOptions& options);

/// Finds the correspondences between strips of different scanners, also of one strip. They may be
/// scanners of different flights. The boresights of aligned scanners must bring the strips together
/// to 18 GSD, as those of MatchFlight do, and are not changed. The others are turned until they
/// agree with all, from coarse to fine as in MatchFlight. What the pairs leave undetermined stays
/// near the given boresights. The ranges of plants are not corrected. Without any overlap the
/// result has no strip pairs. Throws InvalidInput and InvalidConfig like MatchFlight.
MatchResult MatchScanners(ScannersMatchSource* source, const MatchOptions& options);

}  // namespace dn
