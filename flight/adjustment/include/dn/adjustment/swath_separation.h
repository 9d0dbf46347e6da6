#pragma once

#include <dn/report/json.h>

#include <array>

namespace dn {

/// How far swaths are apart in height: shares of pairs of points of their overlap by the difference
/// of height of the two points.
class SwathSeparation {
 public:
  /// up_m: that difference, m.
  void Add(double up_m);

  /// Shares from 0 to 1, NaN without pairs: `to_8_cm`, `8_to_16_cm`, `above_16_cm`, the classes of
  /// the images that the USGS Lidar Base Specification asks for; `within_3_cm`, `within_5_cm`,
  /// `within_10_cm`, the standard levels of Leica HxMap's comparison of strips.
  Json ToJson() const;

 private:
  long pairs_ = 0;
  std::array<long, 5> within_{};  ///< 3, 5, 8, 10, 16 cm
};

}  // namespace dn
