#pragma once

#include <dn/calibration/swath_separation.h>
#include <dn/matching/match.h>
#include <dn/report/json.h>

#include <string>
#include <vector>

namespace dn {

/// How far the points of pairs are apart.
struct Misalignment {
  double mean_m = 0.0, rms_m = 0.0, median_m = 0.0, p95_m = 0.0, max_m = 0.0;  ///< of the norm
  Eigen::Vector3d mean_enu_m = Eigen::Vector3d::Zero();
  double heading_deg = 0.0;  ///< of the mean horizontal difference i - j, from north over east
  /// Length of the mean horizontal direction: 1 where all differences point the same way, near 0
  /// where they point anywhere.
  double same_direction = 0.0;
  SwathSeparation separation;
};

/// differences_m: p_i - p_j in m, at least one.
Misalignment MisalignmentOf(const std::vector<Eigen::Vector3d>& differences_m);

/// How evenly the pairs lie: mean distance to the nearest other pair by that of as many points
/// anywhere in the area (Clark and Evans 1954): 1 at random, below 1 in clusters, above 1 even. 0 of
/// fewer than two pairs.
double EvennessOf(const std::vector<MatchedPair>& pairs, double area_m2);

/// Counts per stage, misalignment before and after, levels, strips: match.json.
Json MatchJson(const std::string& name, const MatchResult& result, const MatchSource& source);

/// A line per pair: t_i, t_j, p_j (east, north, up), the difference p_i - p_j before and after, its
/// sigmas, radius of the patches; m.
std::string FormatMatches(const StripPairMatch& match);

}  // namespace dn
