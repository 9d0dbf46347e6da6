#pragma once

#include <dn/calibration/gauss_helmert_flight.h>

namespace dn::internal {

/// Fills diversity and mean_range_m.
void DescribeStrips(const Flight& flight, const std::vector<StripInterval>& strips,
                    GaussHelmertCalibration* calibration);

/// Fills verdict and reasons of a calibration that is otherwise complete.
void Assess(const Flight& flight, GaussHelmertCalibration* calibration);

}  // namespace dn::internal
