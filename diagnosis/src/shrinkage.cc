#include "shrinkage.h"

#include <algorithm>
#include <utility>

namespace dn::diagnosis_internal {
namespace {

// A gap is visible in the omnibus statistic below this p-value.
constexpr double kVisible = 0.05;

}  // namespace

GapShrinkage MakeShrinkage(double excess, double left, std::vector<double> deviations) {
  std::sort(deviations.begin(), deviations.end());
  const auto closed = [&](double p) {
    const double usual =
        deviations[static_cast<std::size_t>(p * static_cast<double>(deviations.size() - 1))];
    return 1.0 - std::max(0.0, left - usual) / excess;
  };
  GapShrinkage shrinkage;
  shrinkage.fraction = 1.0 - std::max(0.0, left) / excess;
  shrinkage.interval_low = closed(0.025);
  shrinkage.interval_high = closed(0.975);
  return shrinkage;
}

GapShrinkage OmnibusShrinkage(const GapEvidence& before, const GapEvidence& after) {
  // A gap that shows only in raw data and outliers leaves the location statistics like those of
  // replicates.
  if (before.test.p_omnibus > kVisible && after.test.p_omnibus > kVisible) {
    GapShrinkage shrinkage;
    shrinkage.fraction = shrinkage.interval_high = 1.0;
    return shrinkage;
  }
  const double excess =
      std::max(before.test.omnibus - before.test.omnibus_mean, 1e-9) + 2.0 * before.outside_nats;
  const double left = after.test.omnibus - after.test.omnibus_mean + 2.0 * after.outside_nats;
  std::vector<double> deviations;
  for (const double omnibus : after.test.omnibus_of_replicates) {
    deviations.push_back(omnibus - after.test.omnibus_mean);
  }
  return MakeShrinkage(excess, left, std::move(deviations));
}

}  // namespace dn::diagnosis_internal
