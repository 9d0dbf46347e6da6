#pragma once

#include <string>
#include <string_view>

namespace dn::files_internal {

/// Quantity and unit of a column, determined from its name in a header.
struct ColumnMeaning {
  /// A name that CheckColumnNames accepts, or h_msl; empty if the name says nothing known. Also
  /// kOtherQuantity, kRowCount, and kRate or kForce without an axis.
  std::string name;
  std::string unit;         ///< in lower case, without blanks; empty if the name states none
  std::string sensor = {};  ///< for inertial data: the name without its axis
  int index = -1;           ///< for kRate and kForce: the number at the end of the name
};

/// A quantity that is known but not used, such as a magnetic field.
inline constexpr const char* kOtherQuantity = "other";
/// A number of the row or the packet, which is not a time.
inline constexpr const char* kRowCount = "count";
/// Rates and forces whose axis is a number or a direction, such as "gyro[0]" and "acc_up".
inline constexpr const char* kRate = "w";
inline constexpr const char* kForce = "f";

/// Determines the meaning of names such as "Acc_X", "gyro_y (rad/s)", "field.angular_velocity.z",
/// "GPS TOW (s)", "Latitude [deg]", "sdn(m)" or "East Velocity". Words may come in any order and
/// case, and capitals begin words: "rotationRateX", "IMUAccX".
ColumnMeaning FindMeaning(std::string_view column);

}  // namespace dn::files_internal
