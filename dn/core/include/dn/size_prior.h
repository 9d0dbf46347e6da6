#pragma once

#include <array>
#include <cstddef>

namespace dn {

/// Prior distribution of the size of an error: multiples of its typical size with their
/// probabilities. The sizes are apart by factors of sqrt(10).
struct SizePrior {
  static constexpr std::size_t kSizes = 5;
  static constexpr std::array<double, kSizes> kTimesTypical{0.1, 0.31622776601683794, 1.0,
                                                            3.1622776601683795, 10.0};
  static constexpr std::array<double, kSizes> kProbability{0.1, 0.2, 0.4, 0.2, 0.1};
};

}  // namespace dn
