#pragma once

#include <dn/imu/allan.h>

#include <vector>

namespace dn {

// What an Allan variance takes for granted of its record. Values are those of one axis, evenly
// spaced at dt_s, not empty.

/// A second's mean that departs from the record's by more was no sensor at rest.
inline constexpr double kRestGyroRadps = 0.02;
inline constexpr double kRestAccelMps2 = 0.2;
/// DriftInSigmas beyond which a record is not stationary.
inline constexpr double kDriftSigmas = 4.0;

/// Mean of all values.
double MeanRate(const std::vector<double>& rates);

/// True where the mean over every full second stays within `limit` (unit of the data) of that of
/// the record: a sensor that turned or was moved does not.
bool AtRest(const std::vector<double>& rates, double dt_s, double limit);

/// The mean of the last third less that of the first, in sigmas of what the terms of `fit` let it
/// be, its random walk left out: that may itself be the drift.
double DriftInSigmas(const std::vector<double>& rates, double dt_s, const NoiseFit& fit);

}  // namespace dn
