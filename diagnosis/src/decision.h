#pragma once

#include <dn/diagnosis/diagnose.h>

#include <algorithm>
#include <cstddef>

namespace dn::diagnosis_internal {

/// Evidence threshold for naming an effect. `evidence_95` is the 95 % quantile of the largest
/// evidence in the library over replicates without any effect. The threshold exceeds it by
/// `kSafetyNats`, and is at least `kLeastThresholdNats`.
constexpr double kSafetyNats = 2.0, kLeastThresholdNats = 4.0;
constexpr double ThresholdNats(double evidence_95) {
  return std::max(kLeastThresholdNats, evidence_95 + kSafetyNats);
}
/// Evidence threshold of a design, which has no replicates.
constexpr double kDesignThresholdNats = kLeastThresholdNats + kSafetyNats;
/// Lead in evidence at which an unmodelled discrepancy is preferred to the physical effects.
constexpr double kDiscrepancyLeadNats = 3.0;
/// Lead in evidence at which another effect replaces a selected one.
constexpr double kReplacementLeadNats = 1.0;
/// Largest numbers of effects in a verdict, and of places and statistics in a report.
constexpr std::size_t kMaxCauses = 4, kMaxPlaces = 20, kMaxStatistics = 60;

/// Below this p-value of the flight among its simulated replicates, they do not reproduce the
/// flight.
constexpr double kUnlike = 0.01;

/// Returns the number of linear replicates.
constexpr int NumReplicates(GapOptions::Depth depth) {
  if (depth == GapOptions::Depth::kFull) return 400;
  return depth == GapOptions::Depth::kQuick ? 200 : 100;
}

}  // namespace dn::diagnosis_internal
