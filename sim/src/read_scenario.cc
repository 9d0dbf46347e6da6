#include <dn/error.h>
#include <dn/names.h>
#include <dn/sim/scenario.h>

#include <fstream>
#include <iterator>

#include "shipped_scenarios.h"

namespace dn {
namespace {

std::string ReadText(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (!in) throw InvalidConfig("the scenario file cannot be read", {file.string()});
  return text;
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
  if (std::filesystem::is_regular_file(name_or_path)) return ReadText(name_or_path);
  const std::string shipped = JoinNames(ScenarioNames());
  throw InvalidConfig("'" + name_or_path +
                      "' is neither a scenario file nor a shipped scenario; the nearest one is '" +
                      NearestName(name_or_path, ScenarioNames()) + "'. Shipped: " + shipped);
}

Scenario ReadScenario(const std::string& name_or_path) {
  return ParseScenario(ScenarioText(name_or_path), name_or_path);
}

}  // namespace dn
