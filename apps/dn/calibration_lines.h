#pragma once

#include <dn/adjustment/gauss_helmert_flight.h>
#include <dn/diagnosis/result_files.h>

#include <vector>

#include "calibrate_planes.h"
#include "flight_run.h"

namespace dn::apps {

/// Prints the boresight of the dynamic network with its correlations, residuals and assessment.
void PrintNetwork(const FlightRun& flight_run, const BoresightResult& boresight,
                  const std::vector<UnknownEstimate>& unknowns);

/// Prints the boresight of the Gauss-Helmert adjustment with its sigmas by source.
void PrintGaussHelmert(const FlightConfig& config, const GaussHelmertCalibration& calibration,
                       const RunTimings& timings);

/// Prints the boresight of the planes with its sigmas by source.
void PrintPlaneRun(const FlightConfig& config, const PlaneRun& planes);

/// Prints the difference of two methods; `names` says which.
void PrintDifference(const char* names, const MethodDifference& difference);

}  // namespace dn::apps
