#pragma once

#include <dn/adjustment/unknown_noise.h>
#include <dn/report/json.h>

#include <optional>

#include "command.h"

namespace dn::apps {

/// Estimates the noise of a flight whose imu.grade is unknown and reports progress; nullopt for
/// other flights. The flight then has the estimated noise. Throws as EstimateNoise does.
std::optional<NoiseSizes> EstimateUnknownNoise(AdjustOptions options, Flight* flight, Run* run);

/// Adds `noise`, a list of sizes with name, unit, start, value, sigma and redundancy, and
/// `slow_gnss` if slow GNSS errors were found.
void AddNoise(const NoiseSizes& noise, Json* json);

/// Prints one line per size; nothing without sizes.
void PrintNoise(const std::optional<NoiseSizes>& noise);

}  // namespace dn::apps
