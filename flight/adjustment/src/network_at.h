#pragma once

#include <dn/adjustment/stages.h>

#include <memory>

namespace dn::adjustment_internal {

/// Returns a new INS/GNSS network of the run's flight. Its GNSS epochs are at the times that the
/// calibration gives for their tags, and it starts from the run's present trajectory. An effect
/// that is estimated in the present network stays estimated, and a constant one stays constant.
std::unique_ptr<FlightNetwork> RemakeNetwork(AdjustmentRun& run,
                                             const CalibrationState& calibration);

}  // namespace dn::adjustment_internal
