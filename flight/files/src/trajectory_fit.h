#pragma once

#include "content_fit.h"
#include "text_sample.h"

namespace dn::files_internal {

/// Fits a text to a trajectory: seven or eight columns, or columns that a header names. If the
/// attitude does not follow the course, other orders are tried: quaternions with w last, of the
/// inverse rotation, and longitude before latitude.
ContentFit FitTrajectory(const TextSample& sample);

}  // namespace dn::files_internal
