#pragma once

#include <dn/median.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace dn {

/// Norm of a standardised 3-vector that a good measurement exceeds once in 1.7 million: as much
/// outside as five sigmas of a normal variable leave.
constexpr double kGrossNorm = 5.6;
/// The same of a correspondence, of which a flight has many: as much outside as four sigmas of a
/// normal variable leave (6.3e-5).
constexpr double kGrossPairNorm = 4.68;

/// Variance of whitened 3-vectors by the median of their squared norms, which gross errors in less
/// than half of them do not spoil; at least 1. norm2 must not be empty.
inline double RobustVariance(std::vector<double> norm2) {
  constexpr double kMedianChi2Of3 = 2.366;
  return std::max(1.0, Median(std::move(norm2)) / kMedianChi2Of3);
}

}  // namespace dn
