#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace dn {

/// Variance of whitened 3-vectors by the median of their squared norms, which gross errors in less
/// than half of them do not spoil; at least 1. norm2 must not be empty.
inline double RobustVariance(std::vector<double> norm2) {
  constexpr double kMedianChi2Of3 = 2.366;
  const auto middle = norm2.begin() + static_cast<std::ptrdiff_t>(norm2.size() / 2);
  std::nth_element(norm2.begin(), middle, norm2.end());
  return std::max(1.0, *middle / kMedianChi2Of3);
}

}  // namespace dn
