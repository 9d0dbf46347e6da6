#pragma once

#include <dn/builder/flight_network.h>
#include <dn/solvers/marginals.h>

namespace dn {

/// One pass of the search for gross errors among the GNSS epochs of a solved INS/GNSS network: each
/// position and velocity is compared with what all the other measurements predict for it, whether
/// it is in use or not. The worst ones of each neighbourhood that cannot be noise are taken out,
/// since they may have spoiled the others; those that agree are taken back. Returns how many
/// changed. The threshold grows with the median of the statistics, so that a flight whose sigmas
/// are too small as a whole keeps its measurements.
///
/// `marginals` must be of the network at its present values, with its selected inverse.
long ScreenGnss(FlightNetwork* network, const Marginals& marginals);

}  // namespace dn
