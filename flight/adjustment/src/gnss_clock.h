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

/// Throws SensorsContradict: the GNSS clock is off by more than an adjustment can estimate.
[[noreturn]] void FailFarClock(const Flight& flight, double offset_s, double sigma_s);

/// Throws SensorsContradict if the motion of the GNSS positions is that of the inertial data some
/// seconds or minutes earlier or later (FindGnssLag). No alignment is then meaningful, and noise
/// that is estimated would absorb the contradiction.
void ExpectCommonTime(const Flight& flight);

}  // namespace dn::adjustment_internal
