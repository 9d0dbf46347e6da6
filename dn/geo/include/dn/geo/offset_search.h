#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

namespace dn {

/// The search of the time offset at which a distance is smallest. A grid over the whole range comes
/// first. The best of its offsets are then refined by finer grids around them.
struct OffsetSearch {
  std::size_t refined = 0;  ///< number of offsets that are refined
  double refining = 0.0;    ///< factor from a grid to the next finer one
  double finest_s = 0.0;    ///< grids as fine as this are the last ones

  /// Returns the smallest distance and its offset, s. `distance(offset_s)` may be infinite.
  template <class Distance>
  std::pair<double, double> Best(double from_s, double to_s, double step_s,
                                 const Distance& distance) const {
    std::vector<std::pair<double, double>> found;
    for (double offset_s = from_s; offset_s <= to_s; offset_s += step_s) {
      found.emplace_back(distance(offset_s), offset_s);
    }
    const std::size_t count = std::min(refined, found.size());
    std::partial_sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(count),
                      found.end());
    std::pair<double, double> best{std::numeric_limits<double>::infinity(), 0.0};
    for (std::size_t k = 0; k < count; ++k) {
      best = std::min(best, Refine(found[k], step_s, distance));
    }
    return best;
  }

 private:
  template <class Distance>
  std::pair<double, double> Refine(std::pair<double, double> best, double step_s,
                                   const Distance& distance) const {
    while (step_s > finest_s) {
      const double middle_s = best.second, fine_s = step_s / refining;
      for (double offset_s = middle_s - step_s; offset_s <= middle_s + step_s; offset_s += fine_s) {
        best = std::min(best, {distance(offset_s), offset_s});
      }
      step_s = fine_s;
    }
    return best;
  }
};

}  // namespace dn
