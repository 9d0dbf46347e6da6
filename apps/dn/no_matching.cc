#include <dn/error.h>

#include "calibrate_planes.h"
#include "calibrate_strips.h"
#include "command.h"

namespace dn::apps {

/// Adds a command that only reports that this build lacks PCL.
void AddMatch(CLI::App* program, Action* action) {
  CLI::App* app = program->add_subcommand(
      "match", "Finds point-to-point correspondences in overlapping strips (not in this build)");
  app->allow_extras();
  app->callback([action] {
    *action = [] {
      return Execute("match", {}, [](Run&) {
        throw InvalidConfig(
            "this dn was built without PCL, which matching needs; build it with -DDN_WITH_PCL=ON");
      });
    };
  });
}

std::string WhyNoPlanes(const FlightConfig&) {
  return "this dn was built without PCL, which planes need";
}

PlaneRun CalibrateByPlanes(const Flight&, const FlightConfig& config, const std::string&, Run*) {
  throw InvalidConfig(WhyNoPlanes(config));
}

bool HasStripsAlone(const FlightConfig&) { return false; }

void CalibrateStrips(const FlightConfig&, const std::string&, Run&,
                     const std::function<void(const FlightConfig&)>&) {}

}  // namespace dn::apps
