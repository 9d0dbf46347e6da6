#pragma once

#include <dn/adjustment/stages.h>

#include <memory>

namespace dn::adjustment_internal {

/// Returns a new INS/GNSS network of the run's flight. Its GNSS epochs are at the times that the
/// calibration gives for their tags, and it starts from the run's present trajectory. An effect
/// that is estimated in the present network stays estimated, and a constant one stays constant.
std::unique_ptr<FlightNetwork> RemakeNetwork(AdjustmentRun& run,
                                             const CalibrationState& calibration);

/// Makes the network of the run again, with its pairs and control. The measurements in use and the
/// trajectory are those of the present network.
void RemakeWholeNetwork(AdjustmentRun& run);

}  // namespace dn::adjustment_internal
