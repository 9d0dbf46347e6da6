#pragma once

#include <dn/builder/flight_network.h>

#include "screen.h"

namespace dn::diagnosis_internal {

/// Evaluates a process as states of the network, at several time constants. The evidence is the
/// restricted likelihood of its sigma, which is exact, while the screen truncates the series of
/// cosines. `solved` is the solved network without the process. Skips time constants for which no
/// network can be built. Leaves the effect unchanged if that fails for all of them.
void EvaluateProcess(const FlightNetwork& solved, int threads, HypothesisEvidence* effect);

/// Refines size and time constant of an evaluated process by maximising their joint likelihood. The
/// standard deviations follow from its curvature in their logarithms. That of the time constant is
/// NaN if there is no maximum nearby.
void RefineProcess(const FlightNetwork& solved, int threads, HypothesisEvidence* effect);

}  // namespace dn::diagnosis_internal
