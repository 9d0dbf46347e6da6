#pragma once

#include <dn/adjustment/gauss_helmert_flight.h>
#include <dn/adjustment/plane_flight.h>
#include <dn/diagnosis/model_check.h>

namespace dn::diagnosis_internal {

// Noise may be misstated by a factor of 1.4; a larger factor has another cause.
inline constexpr double kLargestVarianceRatio = 2.0;
// The covariance of the boresight does not cover an error above this many of its sigmas.
inline constexpr double kMaxShiftInSigmas = 1.0;

/// Evaluates the tests of `check` and adds the findings, the contradicting ones first.
void AddFindings(const Adjustment& adjustment, const TrajectoryResult& trajectory,
                 ModelCheck* check);
void AddFindings(const Flight& flight, const GaussHelmertCalibration& calibration,
                 ModelCheck* check);
void AddFindings(const Flight& flight, const PlaneCalibration& calibration, ModelCheck* check);

}  // namespace dn::diagnosis_internal
