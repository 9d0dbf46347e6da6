#pragma once

#include <string>
#include <vector>

namespace dn {

struct ShippedScenario {
  std::string name;
  std::string yaml;
};

/// The scenarios of sim/scenarios, compiled in.
const std::vector<ShippedScenario>& ShippedScenarios();

}  // namespace dn
