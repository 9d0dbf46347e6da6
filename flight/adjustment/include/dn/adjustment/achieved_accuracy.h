#pragma once

#include <dn/calibration/result.h>
#include <dn/report/json.h>

#include <vector>

namespace dn {

/// Standard deviations of a smoothed trajectory over its nodes, of every axis by itself.
struct AchievedAccuracy {
  TrajectorySigma median, largest;  ///< t_s: of no meaning
};

/// There must be a node.
AchievedAccuracy AccuracyOf(const std::vector<TrajectorySigma>& sigma);

/// {"median_enu_m", "largest_enu_m", "median_rph_deg", "largest_rph_deg"}.
Json AccuracyJson(const AchievedAccuracy& accuracy);

}  // namespace dn
