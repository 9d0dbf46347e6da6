#pragma once

#include <dn/adjustment/gauss_helmert_flight.h>

namespace dn::adjustment_internal {

/// Returns the mean length of the laser vectors, m.
double MeanRange(const GaussHelmertProblem& problem);

/// Fills in the verdict and the reasons of an otherwise complete calibration.
void Assess(const Flight& flight, GaussHelmertCalibration* calibration);

}  // namespace dn::adjustment_internal
