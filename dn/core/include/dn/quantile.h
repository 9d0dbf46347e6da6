#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace dn {

/// The value below which a share p of the values lies, 0 <= p <= 1, linear between neighbours; there
/// must be one.
inline double Quantile(std::vector<double> values, double p) {
  std::sort(values.begin(), values.end());
  const double at = p * static_cast<double>(values.size() - 1);
  const auto low = static_cast<std::size_t>(at);
  const std::size_t high = std::min(low + 1, values.size() - 1);
  return values[low] + (at - static_cast<double>(low)) * (values[high] - values[low]);
}

}  // namespace dn
