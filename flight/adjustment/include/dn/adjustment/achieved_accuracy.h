#pragma once

#include <dn/adjustment/result.h>
#include <dn/report/json.h>

#include <vector>

namespace dn {

/// Median and maximum, over the nodes, of the standard deviations of a smoothed trajectory. Each
/// axis is treated by itself.
struct AchievedAccuracy {
  TrajectorySigma median, largest;  ///< their t_s is not set
};

/// Returns the accuracy from the standard deviations at the nodes; `sigma` must not be empty.
AchievedAccuracy SummariseAccuracy(const std::vector<TrajectorySigma>& sigma);

/// Returns {"median_enu_m", "largest_enu_m", "median_rph_deg", "largest_rph_deg"}.
Json AccuracyJson(const AchievedAccuracy& accuracy);

}  // namespace dn
