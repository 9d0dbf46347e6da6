#pragma once

#include <dn/adjustment/swath_separation.h>
#include <dn/matching/match.h>
#include <dn/report/json.h>

#include <string>
#include <vector>

namespace dn {

/// Statistics of the distances between the points of pairs.
struct Misalignment {
  /// Statistics of the lengths of the differences, m.
  double mean_m = 0.0, rms_m = 0.0, median_m = 0.0, p95_m = 0.0, max_m = 0.0;
  Eigen::Vector3d mean_enu_m = Eigen::Vector3d::Zero();
  /// Azimuth of the mean horizontal difference i - j, from north over east.
  double heading_deg = 0.0;
  /// Length of the mean horizontal direction: 1 if all differences have the same direction, near 0
  /// if their directions are random.
  double same_direction = 0.0;
  SwathSeparation separation;
};

/// Returns the statistics of differences p_i - p_j in the map frame, m; at least one is needed.
Misalignment ComputeMisalignment(const std::vector<Eigen::Vector3d>& differences_m);

/// Returns the evenness of the pairs (Clark and Evans 1954). It is the mean distance to the nearest
/// other pair, divided by that of as many random points in the area. It is 1 for random, below 1
/// for clustered, above 1 for even pairs, and 0 for fewer than two pairs.
double ComputeEvenness(const std::vector<MatchedPair>& pairs, double area_m2);

/// Returns match.json: counts per stage, misalignment before and after, levels, strips.
Json MatchJson(const std::string& name, const MatchResult& result, const MatchSource& source);

/// Returns one line per pair, in s and m. A line has t_i, t_j, p_j (east, north, up), the
/// difference p_i - p_j before and after, its sigmas, and the radius of the patches.
std::string FormatMatches(const StripPairMatch& match);

/// Returns one line per surface pair, in s and m. A line has t_i, t_j, p_j and the normal (east,
/// north, up), the distance along the normal i - j before and after, its sigma, and the radius of
/// the cell.
std::string FormatSurfaceMatches(const StripPairMatch& match);

}  // namespace dn
