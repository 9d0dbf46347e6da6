#pragma once

#include <string>
#include <vector>

#include "command.h"

namespace dn::apps {

/// Options of a calibration with several flights.
struct FleetOptions {
  std::string across;                 ///< section `across` as YAML; empty: that of the flights
  int at_once = 1;                    ///< flights that are calibrated at the same time
  bool include_uncalibrated = false;  ///< also takes flights whose verdict is not `calibrated`
  std::string between;                ///< folder with pairs between flights; empty: none
  bool georef = false;                ///< also georeferences the strips of each flight
};

/// Adds --across, --at-once, --include-uncalibrated and --between.
void AddFleetOptions(CLI::App* app, FleetOptions* options);

/// Returns the inputs of all flights. A flight may be a result folder with a reduced.json.
/// `between`: as in FleetOptions.
Inputs FleetInputs(const std::vector<std::string>& flights, const std::vector<std::string>& changes,
                   const std::string& between);

/// Calibrates each flight in a process of its own into --out/<flight>, and combines their results.
/// A flight with a result of the same data and configuration is not calibrated again. `changes`:
/// --set values for all flights. With `georef`, the strips of each flight get new coordinates.
void CalibrateFlights(const std::vector<std::string>& flights,
                      const std::vector<std::string>& changes, const FleetOptions& options,
                      Run& run);

}  // namespace dn::apps
