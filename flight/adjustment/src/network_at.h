#pragma once

#include <dn/calibration/stages.h>

#include <memory>

namespace dn::internal {

/// The INS/GNSS network of the run's flight anew, its GNSS epochs at the times that the calibration
/// makes of their tags, starting from the run's present trajectory. An effect that both networks
/// have is free where it was.
std::unique_ptr<FlightNetwork> NetworkAt(AdjustmentRun& run, const CalibrationState& calibration);

}  // namespace dn::internal
