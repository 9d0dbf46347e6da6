#pragma once

#include <dn/calibration/plane_flight.h>
#include <dn/calibration/result_files.h>
#include <dn/flight/flight.h>

#include <string>
#include <vector>

#include "command.h"

namespace dn::apps {

/// A flight calibrated by the planes of its strips.
struct PlaneRun {
  PlaneCalibration calibration;
  std::vector<std::string> strips;  ///< names
  Json extraction;                  ///< what was found before the adjustment
  RunTimings timings;
};

/// Why this program cannot take planes of a flight; empty: it can.
std::string WhyNoPlanes(const FlightConfig& config);

/// Takes the planes of the flight's strips and calibrates by them. flight: with the trajectory in
/// use. config: as it is in the folder; trajectory: the one in use where that is not the folder's
/// own, else empty. Throws InvalidInput where WhyNoPlanes says so.
PlaneRun CalibrateByPlanes(const Flight& flight, const FlightConfig& config,
                           const std::string& trajectory, Run* run);

/// What report.json holds of it beyond result.json.
Json PlaneReportJson(const PlaneRun& planes);

void PrintPlanes(const PlaneRun& planes);

}  // namespace dn::apps
