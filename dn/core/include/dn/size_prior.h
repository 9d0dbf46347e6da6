#pragma once

#include <array>
#include <cstddef>

namespace dn {

/// What is expected of the size of an error before any data are seen: so many times its usual one,
/// with these probabilities. Equal factors of sqrt(10) lie between the sizes.
struct SizePrior {
  static constexpr std::size_t kSizes = 5;
  static constexpr std::array<double, kSizes> kTimesUsual{0.1, 0.31622776601683794, 1.0,
                                                          3.1622776601683795, 10.0};
  static constexpr std::array<double, kSizes> kProbability{0.1, 0.2, 0.4, 0.2, 0.1};
};

}  // namespace dn
