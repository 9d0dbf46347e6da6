#pragma once

#include <dn/study/study.h>

#include <vector>

#include "joint_covariance.h"

namespace dn {

/// Returns the weakest direction of the boresight, then the directions in which a calibration
/// unknown and others are determined jointly but hardly separately, weakest first. Adds no
/// remedies.
///
/// Let C be the joint covariance, N = C^-1 and D = diag(N)^(-1/2). The directions of jointly
/// determined unknowns are eigenvectors of D N D. The eigenvalues are 1 for unknowns that are
/// determined separately.
std::vector<StudyDirection> StudyDirections(const JointCovariance& joint);

}  // namespace dn
