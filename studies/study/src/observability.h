#pragma once

#include <dn/study/study.h>

#include <vector>

#include "joint_covariance.h"

namespace dn {

/// Free unknowns besides the boresight, with their sigmas.
std::vector<StudyUnknown> UnknownsOf(const JointCovariance& joint, const FlightConfig& config);

/// Those of them that correlate with another calibration unknown by more than 0.999, or whose sigma
/// exceeds a hundred times their usual size: of them is known no more than before.
std::vector<Unobservable> UnobservableOf(const JointCovariance& joint, const FlightConfig& config);

}  // namespace dn
