#pragma once

#include <dn/builder/flight_network.h>

#include <vector>

#include "hypothesis.h"

namespace dn::diagnosis_internal {

/// Returns every effect that the network can be tested for and does not estimate, each with its own
/// block. These are GNSS effects, inertial effects and, with pairs, lidar effects. For a step of
/// the boresight there is one hypothesis per time between two strips, six at most.
///
/// The derivatives are those of the factors that estimate the effect, at the present values. The
/// `discrepancies` come last, in their order; the block of one that acts on no factor is empty.
Library MakeNetworkHypotheses(const FlightNetwork& network, int threads = 1,
                              const std::vector<Hypothesis>& discrepancies = {});

}  // namespace dn::diagnosis_internal
