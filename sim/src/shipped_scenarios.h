#pragma once

#include <string>
#include <vector>

namespace dn {

/// Scenario that comes with the program.
struct ShippedScenario {
  std::string name;
  std::string yaml;
};

/// Returns the scenarios of sim/scenarios, which are compiled in.
const std::vector<ShippedScenario>& ShippedScenarios();

}  // namespace dn
