#pragma once

#include <dn/calibration/gauss_helmert_flight.h>

namespace dn::internal {

/// Of the laser vectors.
double MeanRange(const GaussHelmertProblem& problem);

/// Fills verdict and reasons of a calibration that is otherwise complete.
void Assess(const Flight& flight, GaussHelmertCalibration* calibration);

}  // namespace dn::internal
