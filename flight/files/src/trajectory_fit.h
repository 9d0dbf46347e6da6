#pragma once

#include <vector>

#include "content_fit.h"
#include "picked_columns.h"
#include "text_sample.h"

namespace dn::files_internal {

/// Fits a text to a trajectory: seven or eight columns, or columns that a header names. If the
/// attitude does not follow the course, other orders are tried: quaternions with w last, of the
/// inverse rotation, and longitude before latitude.
ContentFit FitTrajectory(const TextSample& sample);

/// Returns the columns of roll, pitch and heading that a header names; empty if it does not. The
/// unit is that of the names, else deg if an angle exceeds a full turn in rad.
std::vector<NamedColumn> FindAngles(const TextSample& sample);

}  // namespace dn::files_internal
