#pragma once

#include <dn/config/yaml_value.h>
#include <dn/sim/vibration.h>

#include <string>

namespace dn {

/// Reads `plan.vibration`: the name of a preset, or `lines`, `resonances` and `broadband`. Throws
/// InvalidConfig for a value of the wrong type or range.
VibrationScenario ReadVibration(const YamlValue& section);

/// Returns the vibration in the form that ReadVibration reads.
std::string FormatVibration(const VibrationScenario& vibration);

}  // namespace dn
