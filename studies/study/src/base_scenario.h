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

/// Joins a list of unknowns by commas. Throws InvalidConfig, with the location of the list, for a
/// name that is not an unknown.
std::string ReadEstimateList(const YamlValue& list);

}  // namespace dn
