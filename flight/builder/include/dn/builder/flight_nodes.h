#pragma once

#include <dn/builder/calibration_state.h>
#include <dn/builder/node_grid.h>
#include <dn/files/flight.h>

#include <optional>
#include <vector>

namespace dn {

/// Returns the time span of a network: from the first to the last GNSS or pair epoch that the IMU
/// data cover. A piece of less than 10 s before the first or after the last gap of the IMU data is
/// left out unless pairs need it. Its heading would be unknown. The GNSS epochs are the time tags
/// corrected by the calibration (GnssEpochTime). Throws InvalidInput if fewer than three GNSS
/// epochs lie inside the IMU data.
TimeInterval NetworkSpan(const Flight& flight, bool with_pairs,
                         const CalibrationState& calibration = {});

/// Returns the times of the GNSS epochs inside the span, s.
std::vector<double> GnssTimes(const Flight& flight, const TimeInterval& span,
                              const CalibrationState& calibration = {});

/// Use of a network, which decides how well its sigmas must be known.
enum class NodeRateUse {
  kResult,     ///< no sigma may be more than one percent too small
  kDiagnosis,  ///< at most three percent, for a quarter of the time and half of the memory
};

/// Returns the node rate within the strips for `node_rate_hz: auto`, Hz. It is the lowest of 1, 2,
/// 5, 10 and 20 Hz at which the angle random walk of one interval is small. Without pairs the rate
/// is 1 Hz.
///
/// The random walk is conditioned on the rotation to the end of the interval
/// (IncrementConditioning) and taken at the mean laser range. Its limit is a fraction of the
/// variance of the mean of the pairs in the interval. The fraction is a fiftieth at 1 and 2 Hz, and
/// a tenth from 5 Hz. For a diagnosis it is six tenths from 2 Hz. The pairs of an interval share
/// this noise, but the network treats it as independent. The strongest vibration of any strip is
/// assumed for all strips.
double AutoNodeRateHz(const Flight& flight, NodeRateUse use = NodeRateUse::kResult);

/// Returns the node rate within strips, or without pairs over the whole span, Hz. It is that of the
/// configuration or else AutoNodeRateHz, and at least 1 Hz, the rate outside of strips.
double NodeRateHz(const Flight& flight, bool with_pairs);

/// Returns the node times of a flight over a span, at NodeRateHz or with `inertial: raw` at every
/// IMU epoch. The argument `inertial` overrides the configuration.
std::vector<double> FlightNodeTimes(const Flight& flight, const TimeInterval& span, bool with_pairs,
                                    const CalibrationState& calibration = {},
                                    std::optional<NetworkConfig::Inertial> inertial = {});

}  // namespace dn
