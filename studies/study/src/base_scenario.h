#pragma once

#include <dn/config/yaml_value.h>

#include <string>

namespace dn {

/// The base that a file for `dn study` names: a shipped scenario, else a file in the same folder.
struct BaseScenario {
  std::string path;
  std::string text;
};

/// Reads the base; `where` is the file that names it. Throws as ScenarioText.
BaseScenario ReadBaseScenario(const YamlValue& base, const std::string& where);

/// Joins the elements of a YAML list by commas.
std::string JoinedYaml(const YamlValue& list);

/// The same of a list of unknowns. Throws InvalidConfig at its place for a name of none.
std::string ReadEstimateList(const YamlValue& list);

}  // namespace dn
