#pragma once

#include <dn/report/json.h>

#include <array>

namespace dn {

/// Height separation of swaths: shares of the point pairs in their overlap by the height difference
/// of the two points.
class SwathSeparation {
 public:
  /// Adds a pair; up_m is its height difference, m.
  void Add(double up_m);

  /// Returns shares from 0 to 1, NaN without pairs. `to_8_cm`, `8_to_16_cm` and `above_16_cm` are
  /// the classes of the images in the USGS Lidar Base Specification. `within_3_cm`, `within_5_cm`
  /// and `within_10_cm` are the standard levels of the strip comparison in Leica HxMap.
  Json ToJson() const;

 private:
  long pairs_ = 0;
  std::array<long, 5> within_{};  ///< 3, 5, 8, 10, 16 cm
};

}  // namespace dn
