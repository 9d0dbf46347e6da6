#include <dn/config/yaml_value.h>
#include <dn/error.h>
#include <dn/geo/read_file.h>
#include <dn/names.h>
#include <dn/sim/scenario.h>

#include <filesystem>

#include "shipped_scenarios.h"

namespace dn {
namespace {

std::string ReadText(const std::filesystem::path& file) {
  try {
    return ReadWholeFile(file, kMaxYamlBytes);
  } catch (const InvalidInput& e) {
    throw InvalidConfig(e.what(), e.where());
  }
}

}  // namespace

std::vector<std::string> ScenarioNames() {
  std::vector<std::string> names;
  for (const ShippedScenario& scenario : ShippedScenarios()) names.push_back(scenario.name);
  return names;
}

std::string ScenarioText(const std::string& name_or_path) {
  for (const ShippedScenario& scenario : ShippedScenarios()) {
    if (scenario.name == name_or_path) return scenario.yaml;
  }
  std::error_code none;
  if (std::filesystem::status(name_or_path, none).type() != std::filesystem::file_type::not_found) {
    return ReadText(name_or_path);
  }
  const std::string shipped = JoinNames(ScenarioNames());
  throw InvalidConfig(
      "'" + name_or_path + "' is neither a scenario file nor a shipped scenario; did you mean '" +
      NearestName(name_or_path, ScenarioNames()) + "'? Shipped scenarios: " + shipped);
}

Scenario ReadScenario(const std::string& name_or_path, const std::vector<std::string>& changes) {
  return ParseScenario(WithYamlChanges(ScenarioText(name_or_path), changes, "strips=true"),
                       name_or_path);
}

}  // namespace dn
