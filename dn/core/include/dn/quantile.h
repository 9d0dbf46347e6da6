#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace dn {

/// Returns the p-quantile of the values, 0 <= p <= 1, with linear interpolation. The list must not
/// be empty.
inline double Quantile(std::vector<double> values, double p) {
  std::sort(values.begin(), values.end());
  const double at = p * static_cast<double>(values.size() - 1);
  const auto low = static_cast<std::size_t>(at);
  const std::size_t high = std::min(low + 1, values.size() - 1);
  return values[low] + (at - static_cast<double>(low)) * (values[high] - values[low]);
}

}  // namespace dn
