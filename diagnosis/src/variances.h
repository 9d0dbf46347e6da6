#pragma once

#include <dn/builder/flight_network.h>
#include <dn/diagnosis/diagnosis.h>
#include <dn/solvers/marginals.h>

#include <optional>
#include <vector>

#include "library.h"
#include "screen.h"

namespace dn::diagnosis_internal {

/// Evidence on the sizes of the stated noise. GNSS and pairs use the restricted likelihood of the
/// network; inertial sensors use the high band of their raw data. Effects are in SI; their evidence
/// is comparable with that of the screen.
struct VarianceScreen {
  std::vector<HypothesisEvidence> effects;
  /// Evidence of inertial noise that is not white or not steady, relative to the best model with
  /// white noise, nats. No effect of the table describes such noise.
  double coloured_imu = 0.0;
};

/// Screens the noise relative to the configuration of the network's flight, including its
/// vibration.
VarianceScreen ScreenVariances(const FlightNetwork& network, const Marginals& marginals,
                               const LibraryOptions& options);

}  // namespace dn::diagnosis_internal
