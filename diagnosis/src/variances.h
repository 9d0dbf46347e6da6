#pragma once

#include <dn/builder/flight_network.h>
#include <dn/gap/diagnosis.h>
#include <dn/solvers/marginals.h>

#include <optional>
#include <vector>

#include "library.h"
#include "screen.h"

namespace dn::internal {

/// What the data say about the sizes of the stated noise: of GNSS and pairs by the restricted
/// likelihood of the network, of the inertial sensors by the high band of their raw data. Effects in
/// SI, evidence as that of the screen.
struct VarianceScreen {
  std::vector<ScreenedEffect> effects;
  /// Evidence of inertial noise that is not white or not steady before the best account by white
  /// noise, nats; no effect of the table names it.
  double coloured_imu = 0.0;
};

/// Against what the configuration of the network's flight states, its vibration included.
VarianceScreen ScreenVariances(const FlightNetwork& network, const Marginals& marginals,
                               const LibraryOptions& options);

}  // namespace dn::internal
