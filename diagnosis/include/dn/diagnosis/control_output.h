#pragma once

#include <dn/adjustment/control_checks.h>
#include <dn/report/json.h>

#include <string>

namespace dn {

/// Returns the section `control` of result.json.
Json ControlJson(const ControlCheck& control);

/// Returns lines for the terminal: one per control point, the datum shift, and the accuracy by
/// withheld checks.
std::string ControlSummary(const ControlCheck& control);

}  // namespace dn
