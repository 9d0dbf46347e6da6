#pragma once

#include <compare>

namespace dn::internal {

/// Scale of the errors of a fixed trajectory and its pairs, as numbers of steps from the stated
/// one. A step of position or attitude is an octave.
struct ScaleSteps {
  int position = 0, attitude = 0, white = 0;
  auto operator<=>(const ScaleSteps&) const = default;
};

/// Climbs from a start, one step of one scale at a time, to scales whose neighbours between 0 and
/// `most` are not higher. `height` is a function of the scales.
template <class Height>
ScaleSteps ClimbScales(ScaleSteps top, const ScaleSteps& most, const Height& height) {
  for (bool higher = true; higher;) {
    higher = false;
    for (int ScaleSteps::*which :
         {&ScaleSteps::position, &ScaleSteps::attitude, &ScaleSteps::white}) {
      for (const int step : {-1, 1}) {
        ScaleSteps next = top;
        next.*which += step;
        if (next.*which < 0 || next.*which > most.*which) continue;
        if (height(next) <= height(top)) continue;
        top = next;
        higher = true;
      }
    }
  }
  return top;
}

}  // namespace dn::internal
