#pragma once

#include <algorithm>

namespace dn {

/// State of the position in a row of a log of several sensors.
enum class RowPosition { kNew, kRepeated, kNone };

/// Compares the position of a row (3 values) with that of the last row with one, which is nullptr
/// at the beginning. A latitude and longitude of 0 are no position.
inline RowPosition ComparePosition(const double* position, const double* before) {
  if (position[0] == 0.0 && position[1] == 0.0) return RowPosition::kNone;
  const bool same = before != nullptr && std::equal(position, position + 3, before);
  return same ? RowPosition::kRepeated : RowPosition::kNew;
}

}  // namespace dn
