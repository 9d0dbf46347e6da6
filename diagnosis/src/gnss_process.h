#pragma once

#include <dn/builder/flight_network.h>
#include <dn/solvers/linearized_network.h>

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "hypothesis.h"
#include "process_mixture.h"
#include "time_cells.h"

namespace dn::diagnosis_internal {

/// The time-correlated error of the GNSS positions that gnss.processes: auto assumes, as cosines
/// over the flight on the axes east, north and up.
struct GnssProcessBasis {
  std::size_t block = 0;  ///< index in Library::blocks; east, north, up of each cosine
  Cosines cosines;
  double stated_sigma_m = 0.0;  ///< sigma of the positions, relative to which sizes are stated

  /// Returns the sizes of the prior (GnssProcessPrior), m.
  std::vector<ProcessSize> Sizes() const;
  /// Returns the shapes of the prior, one per time constant.
  std::vector<ProcessShape> Shapes() const;
};

/// Returns whether the size of the process is one that its prior expects: within three standard
/// deviations of its logarithm.
bool IsUsualSize(const ProcessMixture& process);

/// Adds the columns of the process to a library, without a hypothesis. Returns nullopt if the
/// configuration has no such process, or the network has no GNSS position.
std::optional<GnssProcessBasis> AddGnssProcess(const FlightNetwork& network,
                                               const LinearizedNetwork& linearized,
                                               Library* library);

}  // namespace dn::diagnosis_internal
