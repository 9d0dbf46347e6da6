#include "shrinkage.h"

#include <algorithm>
#include <vector>

namespace dn::internal {
namespace {

// A gap is visible in the omnibus statistic below this p-value.
constexpr double kVisible = 0.05;

}  // namespace

GapShrinkage OmnibusShrinkage(const Departure& before, const Departure& after) {
  const double outside = 2.0 * before.outside_nats;
  const double excess = std::max(before.test.omnibus - before.test.omnibus_mean, 1e-9) + outside;
  const double left = after.test.omnibus - after.test.omnibus_mean + 2.0 * after.outside_nats;
  std::vector<double> off;
  for (const double twin : after.test.omnibus_of_replicates) {
    off.push_back(twin - after.test.omnibus_mean);
  }
  std::sort(off.begin(), off.end());
  const auto closed = [&](double p) {
    const double usual = off[static_cast<std::size_t>(p * static_cast<double>(off.size() - 1))];
    return 1.0 - std::max(0.0, left - usual) / excess;
  };
  GapShrinkage shrinkage;
  // A gap that shows only in raw data and outliers leaves the location statistics like those of
  // replicates.
  if (before.test.p_omnibus > kVisible && after.test.p_omnibus > kVisible) {
    shrinkage.fraction = shrinkage.interval_high = 1.0;
    return shrinkage;
  }
  shrinkage.fraction = 1.0 - std::max(0.0, left) / excess;
  shrinkage.interval_low = closed(0.025);
  shrinkage.interval_high = closed(0.975);
  return shrinkage;
}

}  // namespace dn::internal
