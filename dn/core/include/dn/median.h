#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace dn {

/// Ratio of the standard deviation of normal errors to the median of their absolute values.
inline constexpr double kSigmaPerMedian = 1.4826;

/// Returns the median of the values; for an even number, the upper of the two middle values. The
/// list must not be empty.
inline double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace dn
