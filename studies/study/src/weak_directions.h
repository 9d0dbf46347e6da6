#pragma once

#include <dn/study/study.h>

#include <vector>

#include "joint_covariance.h"

namespace dn {

/// The weakest direction of the boresight, then those in which a calibration unknown and others are
/// determined together but hardly apart, the weakest first. Without remedies.
///
/// With C the joint covariance, N = C^-1 and D = diag(N)^(-1/2), the latter are eigenvectors of
/// D N D, whose eigenvalues are 1 where unknowns are determined apart.
std::vector<StudyDirection> StudyDirections(const JointCovariance& joint);

}  // namespace dn
