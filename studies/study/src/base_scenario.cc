#include "base_scenario.h"

#include <dn/error.h>
#include <dn/sim/scenario.h>
#include <dn/study/design.h>

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <vector>

namespace dn {

BaseScenario ReadBaseScenario(const YamlValue& base, const std::string& where) {
  std::string path = base.Text();
  const std::vector<std::string> shipped = ScenarioNames();
  if (std::find(shipped.begin(), shipped.end(), path) == shipped.end()) {
    const std::filesystem::path beside = std::filesystem::path(where).parent_path() / path;
    std::error_code none;
    if (std::filesystem::exists(beside, none)) path = beside.string();
  }
  std::string text = ScenarioText(path);
  return {std::move(path), std::move(text)};
}

std::string JoinedYaml(const YamlValue& list) {
  std::string text;
  for (const YamlValue& item : list.List()) text += (text.empty() ? "" : ", ") + item.Yaml();
  return text;
}

std::string ReadEstimateList(const YamlValue& list) {
  std::string text = JoinedYaml(list);
  try {
    ParseEstimate(text);
  } catch (const InvalidConfig& error) {
    throw InvalidConfig(error.what(), list.where());
  }
  return text;
}

}  // namespace dn
