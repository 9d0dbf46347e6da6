#pragma once

#include <dn/adjustment/plane_flight.h>
#include <dn/diagnosis/model_check.h>
#include <dn/files/flight.h>

#include <optional>

namespace dn::diagnosis_internal {

/// Returns what the unmodelled effects of the scanner add to the boresight of a plane adjustment;
/// nullopt for the pure model. The adjustment does not estimate them: the angles stay, and the
/// covariance has the whole prior.
std::optional<UnmodelledEffects> PlaneEffects(const Flight& flight,
                                              const PlaneCalibration& calibration);

}  // namespace dn::diagnosis_internal
