#include <dn/effects/effect_table.h>
#include <dn/sim/scenario.h>

#include <utility>

namespace dn {
namespace {

/// Returns the scenario with one of its scanners.
Scenario WithScanner(Scenario scenario, LidarScenario lidar) {
  scenario.pairs.sigma_p_m *= lidar.gsd_m / scenario.lidar.gsd_m;
  std::erase_if(scenario.effects, [&](const Effect& effect) {
    return !effect.scanner.empty() && effect.scanner != lidar.name;
  });
  scenario.lidar = std::move(lidar);
  scenario.more_scanners.clear();
  return scenario;
}

}  // namespace

std::vector<Scenario> ScannerScenarios(const Scenario& scenario) {
  if (scenario.more_scanners.empty()) return {scenario};
  std::vector<Scenario> scenarios{WithScanner(scenario, scenario.lidar)};
  for (const LidarScenario& lidar : scenario.more_scanners) {
    scenarios.push_back(WithScanner(scenario, lidar));
  }
  return scenarios;
}

void ExpectOneScanner(const Scenario& scenario, const std::string& command) {
  if (scenario.more_scanners.empty()) return;
  throw InvalidConfig("scenario '" + scenario.name + "' has " +
                      std::to_string(1 + scenario.more_scanners.size()) + " scanners, and " +
                      command + " takes one: leave one under lidar");
}

}  // namespace dn
