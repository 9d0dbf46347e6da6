#pragma once

#include <optional>

#include "content_fit.h"
#include "picked_columns.h"
#include "text_sample.h"

namespace dn::files_internal {

/// Fits a text to inertial data. Without names in a header, every choice of three adjacent columns
/// for the rates and three for the forces is tried. Force is the vector of about 1 g, in m/s^2 or g
/// or times the step, that keeps it when averaged over seconds. Its length is not constant, unlike
/// that of gravity alone. Rates differ from it in size, and their length is not constant either,
/// unlike that of a magnetic field. Rates are not angles, whose rates are in other columns.
ContentFit FitImu(const TextSample& sample);

/// Returns the time of inertial data; nullopt if no column has plausible steps.
std::optional<TimeColumn> FindImuTime(const TextSample& sample);

}  // namespace dn::files_internal
