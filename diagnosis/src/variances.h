#pragma once

#include <dn/builder/flight_network.h>
#include <dn/diagnosis/diagnosis.h>
#include <dn/solvers/marginals.h>

#include <optional>
#include <vector>

#include "library.h"
#include "screen.h"

namespace dn::diagnosis_internal {

/// Evidence on the sizes of the stated noise, by the restricted likelihood of the network. The high
/// band of raw inertial data proposes the noise of these sensors. Effects are in SI; their evidence
/// is comparable with that of the screen.
struct VarianceScreen {
  std::vector<HypothesisEvidence> effects;
  /// Largest evidence of raw inertial data against the stated noise that the residuals of the
  /// network do not show, nats. It is motion of the platform, or noise too small to matter.
  double raw_only_nats = 0.0;
};

/// Screens the noise relative to the configuration of the network's flight, including its
/// vibration.
VarianceScreen ScreenVariances(const FlightNetwork& network, const Marginals& marginals,
                               const LibraryOptions& options);

}  // namespace dn::diagnosis_internal
