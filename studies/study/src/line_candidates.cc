#include <dn/error.h>
#include <dn/geo/local_frame.h>
#include <dn/study/line_choice.h>
#include <fmt/format.h>

#include <cmath>

#include "base_scenario.h"

namespace dn {
namespace {

constexpr std::size_t kFewestLines = 2, kMostLines = 12;

/// Returns all lines as `plan.lines` of a scenario.
std::string LinesYaml(const YamlValue& lines, std::vector<std::string>* names) {
  if (!lines.IsMap()) lines.Fail("expected a map from names to lines");
  *names = lines.Keys();
  if (names->size() < kFewestLines || names->size() > kMostLines) {
    lines.Fail(
        fmt::format("has {} lines, must have {} to {}", names->size(), kFewestLines, kMostLines));
  }
  std::string yaml;
  for (const std::string& name : *names) yaml += (yaml.empty() ? "[" : ", ") + lines[name].Yaml();
  return yaml + "]";
}

/// Returns the scenario with other lines. Their errors are reported in the file that names the
/// lines.
Scenario WithLines(const BaseScenario& base, const std::string& lines_yaml,
                   const YamlValue& lines) {
  try {
    return ParseScenario(WithYamlValue(base.text, "plan.lines", lines_yaml), base.path);
  } catch (const InvalidConfig& error) {
    lines.Fail(std::string("these lines do not fit the base: ") + error.what());
  }
}

}  // namespace

LineCandidates LineCandidates::Parse(const std::string& yaml_text, const std::string& where) {
  const YamlValue root = ParseYaml(yaml_text, where);
  root.ExpectMap({"base", "estimate", "target_deg", "lines"});
  const BaseScenario base = ReadBaseScenario(root["base"], where);
  const Scenario as_it_is = ParseScenario(base.text, base.path);
  if (as_it_is.plan.replay)
    root["base"].Fail("replays a trajectory, which has no lines to choose from");
  if (as_it_is.pairs.count == 0) root["base"].Fail("has no pairs of points");
  LineCandidates candidates;
  const std::string lines_yaml = LinesYaml(root["lines"], &candidates.names);
  candidates.scenario = WithLines(base, lines_yaml, root["lines"]);
  if (root["estimate"]) candidates.estimate = ReadEstimateList(root["estimate"]);
  candidates.target_rad = kRadPerDeg * ReadPositiveVector3(root["target_deg"]);
  candidates.pairs_per_line =
      static_cast<double>(as_it_is.pairs.count) / static_cast<double>(as_it_is.plan.lines.size());
  return candidates;
}

Scenario LineCandidates::With(const std::vector<std::size_t>& lines) const {
  Scenario some = scenario;
  some.plan.lines.clear();
  for (const std::size_t k : lines) some.plan.lines.push_back(scenario.plan.lines[k]);
  some.pairs.count = std::lround(pairs_per_line * static_cast<double>(lines.size()));
  return some;
}

}  // namespace dn
