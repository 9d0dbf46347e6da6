#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace dn {

/// Part of a ray between two ranges, m.
struct Stretch {
  static constexpr double kNowhere = std::numeric_limits<double>::infinity();

  double from_m, to_m;
  bool empty() const { return !(from_m <= to_m); }

  /// Returns the part with |start + rate t| <= half.
  Stretch Within(double start, double rate, double half) const {
    if (rate == 0.0) return std::abs(start) <= half ? *this : Stretch{kNowhere, -kNowhere};
    const double a = (-half - start) / rate, b = (half - start) / rate;
    return {std::max(from_m, std::min(a, b)), std::min(to_m, std::max(a, b))};
  }
};

}  // namespace dn
