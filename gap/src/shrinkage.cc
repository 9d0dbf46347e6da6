#include "shrinkage.h"

#include <algorithm>
#include <vector>

namespace dn::internal {
namespace {

// p-value of the omnibus statistic down to which there is nothing to close.
constexpr double kVisible = 0.05;

}  // namespace

GapShrinkage OmnibusShrinkage(const TwinTest& before, const TwinTest& after) {
  const double excess = std::max(before.omnibus - before.omnibus_mean, 1e-9);
  GapShrinkage shrinkage;
  shrinkage.fraction = 1.0 - std::max(0.0, after.omnibus - after.omnibus_mean) / excess;
  std::vector<double> off;
  for (const double twin : after.omnibus_of_twins) off.push_back(twin - after.omnibus_mean);
  std::sort(off.begin(), off.end());
  const auto at = [&](double p) {
    return off[static_cast<std::size_t>(p * static_cast<double>(off.size() - 1))];
  };
  // What shows in raw data and gross errors only leaves the locations as twins have them.
  if (before.p_omnibus > kVisible && after.p_omnibus > kVisible) {
    shrinkage.fraction = shrinkage.interval_high = 1.0;
    return shrinkage;
  }
  const double left = after.omnibus - after.omnibus_mean;
  shrinkage.interval_low = 1.0 - std::max(0.0, left - at(0.025)) / excess;
  shrinkage.interval_high = 1.0 - std::max(0.0, left - at(0.975)) / excess;
  return shrinkage;
}

}  // namespace dn::internal
