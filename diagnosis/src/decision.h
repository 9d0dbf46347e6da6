#pragma once

#include <dn/gap/diagnose.h>

#include <algorithm>
#include <cstddef>

namespace dn::internal {

/// Evidence that an effect must have: by `kSafetyNats` more than one flight in twenty without any
/// effect has somewhere in the library, and no less than `kLeastThresholdNats`.
constexpr double kSafetyNats = 2.0, kLeastThresholdNats = 4.0;
constexpr double ThresholdNats(double evidence_95) {
  return std::max(kLeastThresholdNats, evidence_95 + kSafetyNats);
}
/// Before there are twins to tell.
constexpr double kThresholdOfDesignNats = kLeastThresholdNats + kSafetyNats;
/// Evidence, more than a physical effect has, at which a discrepancy without a name is the better one.
constexpr double kGenericNats = 3.0;
/// By so much another effect must explain the data better to take the place of one that was chosen.
constexpr double kSwapNats = 1.0;
/// Effects of one verdict, places and statistics of one report.
constexpr std::size_t kMostCauses = 4, kMostPlaces = 20, kMostStatistics = 60;

/// Linear twins.
constexpr int NumTwins(GapOptions::Depth depth) {
  if (depth == GapOptions::Depth::kFull) return 400;
  return depth == GapOptions::Depth::kQuick ? 200 : 100;
}

}  // namespace dn::internal
