#pragma once

#include <dn/calibration/gauss_helmert_flight.h>
#include <dn/calibration/model_check.h>
#include <dn/calibration/plane_flight.h>

namespace dn::internal {

/// Significance, for the family of all tests of one flight, at which the model is in doubt.
inline constexpr double kFamilyLevel = 1e-3;

/// Judges what was tested and adds the findings, those that contradict first.
void AddFindings(const Adjustment& adjustment, const TrajectoryResult& trajectory,
                 ModelCheck* check);
void AddFindings(const FlightConfig& config, const GaussHelmertCalibration& calibration,
                 ModelCheck* check);
void AddFindings(const FlightConfig& config, const PlaneCalibration& calibration,
                 ModelCheck* check);

}  // namespace dn::internal
