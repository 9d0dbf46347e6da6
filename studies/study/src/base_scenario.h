#pragma once

#include <dn/config/yaml_value.h>

#include <string>

namespace dn {

/// What a file for `dn study` names as its base: a shipped scenario, else a file beside it.
struct BaseScenario {
  std::string path;
  std::string text;
};

/// `where` is the file that names it. Throws as ScenarioText.
BaseScenario ReadBaseScenario(const YamlValue& base, const std::string& where);

/// The elements of a list of YAML, joined by commas.
std::string JoinedYaml(const YamlValue& list);

/// The same of a list of unknowns. Throws InvalidConfig at its place for a name of none.
std::string ReadEstimateList(const YamlValue& list);

}  // namespace dn
