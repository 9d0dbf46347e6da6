#pragma once

#include <dn/adjustment/adjust.h>
#include <dn/files/flight.h>
#include <dn/gnss/gnss_process.h>

#include <optional>
#include <string>
#include <vector>

namespace dn {

/// A size of the assumed noise that follows from the data of a flight.
struct NoiseSize {
  std::string name;             ///< key of flight.yaml, for example "imu.gyro.white"
  std::string unit;             ///< of `start` and `value`
  double start = 0.0;           ///< size before the estimation, the centre of the prior
  double value = 0.0;           ///< estimated size
  double relative_sigma = 0.0;  ///< standard deviation of the estimate over its value
  double redundancy = 0.0;      ///< redundancy of the residuals that show the size
};

/// Estimated noise of a flight.
struct NoiseSizes {
  std::vector<NoiseSize> sizes;
  int rounds = 0;          ///< number of adjustments
  bool converged = false;  ///< false: the last round still changed a size by more than 3 %
  /// Slow errors of the GNSS positions, if the flight shows that most of the stated ones are slow.
  std::optional<GnssProcess> slow_gnss;
};

/// Returns true if the flight states that the noise of its inertial unit is not known
/// (imu.grade: unknown).
bool HasUnknownNoise(const FlightConfig& config);

/// Estimates the noise of the sensors from an adjustment of the flight, and sets it in the
/// configuration of the flight. The sizes are
///
///   white noise of gyros and accelerometers
///   their Gauss-Markov processes and random walks; random constants keep their sizes
///   gnss.sigma_scale, and gnss.velocity_sigma_scale if velocities are in use
///
/// Each variance has an inverse gamma prior of one degree of freedom with its start value. The size
/// may therefore differ by a factor of ten and more. The start value of the white noise is that of
/// the raw data unless the flight states one. With the residuals r of a channel, whose redundancy
/// is f, the estimates solve the equations of restricted maximum likelihood by Förstner's
/// iteration,
///
///   sigma^2 <- (sigma_0^2 + sigma^2 r^T r) / (1 + f),
///
/// with a new adjustment in each round. Outliers are searched in the first round, and again once
/// the sizes have converged; the rounds go on if this changes the sizes. Both scales of GNSS do not
/// fall below their start values: the residuals do not show errors that epochs share over minutes.
/// The exception are positions whose errors are slow (FindSlowGnssErrors): sigma_scale then falls
/// to the white part, and gnss.processes gets the rest. The rounds go on with an unknown clock.
///
/// If the sensors contradict each other with the start sizes, larger ones are tried first. A round
/// that fails later ends the estimation with the latest sizes for which the search for outliers
/// worked. If the adjustment finds that the GNSS clock is off (Adjustment::gnss_clock), offset and
/// drift of the clock are unknowns while the noise is estimated. The `estimate` of the flight does
/// not change.
///
/// Throws as Adjust does.
NoiseSizes EstimateNoise(const AdjustOptions& options, Flight* flight);

}  // namespace dn
