#pragma once

#include <dn/study/study.h>

#include <vector>

#include "joint_covariance.h"

namespace dn {

/// Returns the free unknowns other than the boresight, with their sigmas.
std::vector<StudyUnknown> ListUnknowns(const JointCovariance& joint, const FlightConfig& config);

/// Returns those of them that correlate with another calibration unknown by more than 0.999. Also
/// returns those with a sigma above a hundred times their typical size. The design gives no
/// information on them.
std::vector<Unobservable> FindUnobservable(const JointCovariance& joint,
                                           const FlightConfig& config);

}  // namespace dn
