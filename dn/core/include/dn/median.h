#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace dn {

/// The standard deviation of normal errors, in medians of their absolute values.
inline constexpr double kSigmaOfMedian = 1.4826;

/// The middle one of the values in order, of an even number the upper one of the two; there must be
/// one.
inline double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace dn
