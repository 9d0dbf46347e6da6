#pragma once

#include <dn/study/study.h>

#include <vector>

#include "joint_covariance.h"

namespace dn {

/// Returns the free unknowns other than the boresight, with their sigmas.
std::vector<StudyUnknown> ListUnknowns(const JointCovariance& joint, const FlightConfig& config);

/// Returns the unknowns of ListUnknowns on which the design gives no information. They correlate
/// with another calibration unknown by more than 0.999, or their sigma is above a hundred times
/// their typical size.
std::vector<Unobservable> FindUnobservable(const JointCovariance& joint,
                                           const FlightConfig& config);

}  // namespace dn
