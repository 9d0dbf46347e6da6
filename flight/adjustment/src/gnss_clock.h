#pragma once

#include <dn/builder/calibration_state.h>
#include <dn/files/flight.h>

namespace dn::adjustment_internal {

/// Adds offset and drift of the GNSS clock to the unknowns of the flight.
void EstimateGnssClock(FlightConfig* config);

/// Adds an offset (s) and a drift (s/s) to those of a calibration. If it has none, they start at
/// zero.
void AddToGnssClock(const Flight& flight, double offset_s, double drift,
                    CalibrationState* calibration);

}  // namespace dn::adjustment_internal
