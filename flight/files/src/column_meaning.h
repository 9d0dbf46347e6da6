#pragma once

#include <string>
#include <string_view>

namespace dn::files_internal {

/// Quantity and unit of a column, determined from its name in a header.
struct ColumnMeaning {
  /// A name that CheckColumnNames accepts, or h_msl; empty if the name says nothing known.
  std::string name;
  std::string unit;  ///< in lower case, without blanks; empty if the name states none
};

/// Determines the meaning of names such as "Acc_X", "gyro_y (rad/s)", "field.angular_velocity.z",
/// "GPS TOW (s)", "Latitude [deg]", "sdn(m)" or "East Velocity". Words may come in any order and
/// case.
ColumnMeaning FindMeaning(std::string_view column);

}  // namespace dn::files_internal
