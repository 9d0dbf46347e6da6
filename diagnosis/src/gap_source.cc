#include "gap_source.h"

#include "decision.h"

namespace dn::diagnosis_internal {

void FillFingerprint(const Comparison& comparison, std::size_t most, GapDiagnosis* diagnosis) {
  const ReplicateTest& test = comparison.test;
  for (const Eigen::Index k : test.LargestFirst()) {
    if (diagnosis->fingerprint.size() >= most) return;
    diagnosis->fingerprint.push_back(
        {StatisticName(comparison.statistics[static_cast<std::size_t>(k)]),
         comparison.appearance.locations[k], test.mean[k], test.sigma[k], std::nullopt,
         std::nullopt});
  }
}

void AppendPlaces(const Comparison& comparison, double alpha, GapDiagnosis* diagnosis) {
  const ReplicateTest& test = comparison.test;
  for (const Eigen::Index k : test.LargestFirst()) {
    if (diagnosis->where.size() >= kMaxPlaces) return;
    if (test.p_adjusted[k] > alpha) continue;
    const LocationStatistic& at = comparison.statistics[static_cast<std::size_t>(k)];
    diagnosis->where.push_back({at.sensor, at.quantity,
                                at.location.empty() ? "the whole flight" : at.location, test.z[k],
                                test.p_adjusted[k]});
  }
}

}  // namespace dn::diagnosis_internal
