#pragma once

#include <dn/builder/flight_network.h>
#include <dn/gnss/gnss_process.h>
#include <dn/solvers/linearized_network.h>

#include <optional>

namespace dn {

/// Stated errors of GNSS positions, divided into a white and a slow part.
struct SlowGnssErrors {
  double white_share = 1.0;  ///< sigma of the white part over the stated sigma
  GnssProcess process;       ///< the slow part
};

/// Divides the stated errors of the GNSS positions if the positions change from epoch to epoch by
/// less than half of what white noise of the stated sigmas would cause. Code receivers and filtered
/// positions are of this kind: their errors are correlated over minutes.
///
/// Let e_i be the residual of position i along an axis, divided by its stated sigma, and
///
///   D(T) = mean of (e_j - e_i)^2 / 2 over all epochs i, j with t_j - t_i = T,
///
/// on the axis where it is largest. Inertial data keep the trajectory smooth over some seconds, so
/// that D is that of the GNSS errors. The white part gets the variance D of the shortest interval
/// from 1 s on, since receivers filter their positions. The slow part gets the rest of the stated
/// variance, because one flight cannot show an error that all its positions share. Its time
/// constant is the shortest that any interval up to 8 s demands:
///
///   D(T) = white_share^2 + (1 - white_share^2) (1 - exp(-T / tau)).
///
/// Returns nullopt if the positions are noisier, or if there are fewer than 50.
/// `linearized` must belong to the network without gnss.processes.
std::optional<SlowGnssErrors> FindSlowGnssErrors(const FlightNetwork& network,
                                                 const LinearizedNetwork& linearized);

}  // namespace dn
