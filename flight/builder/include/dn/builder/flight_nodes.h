#pragma once

#include <dn/builder/calibration_state.h>
#include <dn/builder/node_grid.h>
#include <dn/flight/flight.h>

#include <optional>
#include <vector>

namespace dn {

/// The part of the flight that a network can span: from the first to the last GNSS epoch or pair
/// epoch that the IMU data cover. Throws InvalidInput when fewer than three GNSS epochs lie inside
/// the IMU data. The GNSS epochs are those that the calibration makes of the tags (GnssEpochTime).
TimeInterval NetworkSpan(const Flight& flight, bool with_pairs,
                         const CalibrationState& calibration = {});

/// Times of the GNSS epochs inside the span.
std::vector<double> GnssTimes(const Flight& flight, const TimeInterval& span,
                              const CalibrationState& calibration = {});

/// Node rate within the strips for `node_rate_hz: auto`: the lowest of 1, 2, 5, 10 and 20 Hz at
/// which the angle random walk of one interval, less what the bridge to its end takes of it, seen at
/// the mean laser range, has a small share of the variance of the mean of the pairs in that interval:
/// a fiftieth at 1 and 2 Hz, a tenth from 5 Hz on. The pairs of an interval have that noise in
/// common, which the network takes as independent; no sigma falls by more than 1 %. The strongest
/// vibration of a strip counts as if all strips had it. Without pairs 1 Hz.
double AutoNodeRateHz(const Flight& flight);

/// The rate of the nodes, Hz: within strips, and without pairs over the whole span. That of the
/// configuration, else AutoNodeRateHz; at least 1 Hz, the rate everywhere else.
double NodeRateHz(const Flight& flight, bool with_pairs);

/// The nodes of a flight's network over a span, at NodeRateHz; with `inertial: raw` at every IMU
/// epoch. `inertial`: instead of the configuration's.
std::vector<double> FlightNodeTimes(const Flight& flight, const TimeInterval& span, bool with_pairs,
                                    const CalibrationState& calibration = {},
                                    std::optional<NetworkConfig::Inertial> inertial = {});

}  // namespace dn
