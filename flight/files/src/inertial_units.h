#pragma once

#include <optional>
#include <string>

namespace dn::files_internal {

/// Returns the rad/s (or rad) of one unit of rates such as "deg/s", "mrad s^-1", "dps" or "rads".
/// The unit is in lower case, without blanks. Returns nullopt for other texts.
std::optional<double> RateUnitSize(const std::string& unit);

/// Returns the m/s^2 (or m/s) of one unit of forces such as "m/s2", "mg" or "g".
std::optional<double> ForceUnitSize(const std::string& unit);

/// Returns whether a text states a unit of rates, known or not.
bool StatesRateUnit(const std::string& unit);

/// Returns whether a text states a unit of forces, known or not.
bool StatesForceUnit(const std::string& unit);

}  // namespace dn::files_internal
