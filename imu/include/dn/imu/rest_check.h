#pragma once

#include <dn/imu/allan.h>

#include <vector>

namespace dn {

// Checks of the assumptions that an Allan variance makes about its record. Each function takes the
// values of one axis, evenly spaced at dt_s and not empty.

/// Limits for a sensor at rest: deviation of the mean over one second from the mean of the record.
inline constexpr double kRestGyroRadps = 0.02;
inline constexpr double kRestAccelMps2 = 0.2;
/// Limit of DriftInSigmas above which a record is not stationary.
inline constexpr double kDriftSigmas = 4.0;

/// Returns the mean of all values.
double MeanRate(const std::vector<double>& rates);

/// Returns true if the mean over every full second differs from the mean of the record by at most
/// `limit` (unit of the data). A sensor that was turned or moved exceeds the limit.
bool AtRest(const std::vector<double>& rates, double dt_s, double limit);

/// Returns the mean of the last third minus that of the first third, in units of the standard
/// deviation that the terms of `fit` predict. The random walk is excluded, because it can itself
/// represent the drift.
double DriftInSigmas(const std::vector<double>& rates, double dt_s, const NoiseFit& fit);

}  // namespace dn
