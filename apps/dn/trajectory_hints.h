#pragma once

#include <string>
#include <vector>

#include "data_hints.h"

namespace dn::apps {

/// Returns a hint for each way in which the trajectory does not belong to the GNSS positions and
/// the inertial data that were read with it: place, time, height and attitude. `agreement` tells
/// which of trajectory and GNSS the inertial data confirm.
std::vector<DataHint> TrajectoryHints(const Flight& flight, const DataAgreement& agreement);

/// Reads trajectory, GNSS and inertial data of a flight, as far as they can be read, and returns
/// the hints.
std::vector<DataHint> TrajectoryHints(const FlightConfig& config);

}  // namespace dn::apps
