#pragma once

#include <dn/adjustment/plane_flight.h>
#include <dn/diagnosis/result_files.h>
#include <dn/files/flight.h>

#include <string>
#include <vector>

#include "command.h"

namespace dn::apps {

/// Result of the plane calibration of a flight.
struct PlaneRun {
  PlaneCalibration calibration;
  ModelCheck check;
  std::vector<std::string> strips;  ///< names
  Json extraction;                  ///< counts of the plane extraction
  RunTimings timings;
};

/// Returns why planes cannot be extracted from the flight's strips, or an empty string if they can.
std::string WhyNoPlanes(const FlightConfig& config);

/// Extracts planes from the flight's strips and calibrates with them.
/// flight: contains the trajectory in use. config: the configuration of the flight folder.
/// trajectory: file of the trajectory in use; empty if it is the folder's own.
/// Throws InvalidInput if WhyNoPlanes gives a reason.
PlaneRun CalibrateByPlanes(const Flight& flight, const FlightConfig& config,
                           const std::string& trajectory, Run* run);

/// Returns the entries of a plane calibration that report.json has in addition to result.json.
Json PlaneReportJson(const PlaneRun& planes);

void PrintPlanes(const PlaneRun& planes);

}  // namespace dn::apps
