#pragma once

#include <dn/geo/text_table.h>

namespace dn::files_internal {

// Tests of rows of time, two coordinates and a height, as GnssRows gives them.

/// Returns whether columns 2 to 4 can be latitude, longitude and height with a plausible speed. The
/// first two may be exchanged, or in radians.
bool AreCoordinates(const TextTable& table);

/// Returns whether the longitude comes first, which is certain only beyond 90 deg.
bool IsLongitudeFirst(const TextTable& table);

/// Returns whether columns 2 to 4 are certainly a path: AreCoordinates, with
/// decimals as positions have them, and with a median speed below the limit.
bool AreCertainCoordinates(const TextTable& table);

/// Returns whether a column has whole numbers only.
bool AreIntegers(const TextTable& table, std::size_t at);

/// Returns whether the position changes.
bool IsMoving(const TextTable& table);

/// Returns the largest absolute value of a column.
double LargestValue(const TextTable& table, std::size_t at);

}  // namespace dn::files_internal
