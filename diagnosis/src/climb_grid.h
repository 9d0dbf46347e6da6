#pragma once

#include <initializer_list>
#include <utility>

namespace dn::diagnosis_internal {

/// Climbs on a grid of whole numbers from a point to one that no neighbour exceeds. `axes` are the
/// coordinates with their largest values; the smallest is 0. `height` returns the height of a
/// point.
template <class Point, class Height>
Point ClimbGrid(Point top, std::initializer_list<std::pair<int Point::*, int>> axes,
                const Height& height) {
  for (bool higher = true; higher;) {
    higher = false;
    for (const auto& [axis, largest] : axes) {
      for (const int step : {-1, 1}) {
        Point next = top;
        next.*axis += step;
        if (next.*axis < 0 || next.*axis > largest) continue;
        if (height(next) <= height(top)) continue;
        top = next;
        higher = true;
      }
    }
  }
  return top;
}

}  // namespace dn::diagnosis_internal
