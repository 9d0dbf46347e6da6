#pragma once

#include "content_fit.h"
#include "text_sample.h"

namespace dn::files_internal {

/// Fits a text to inertial data. Without names in a header, every choice of three adjacent columns
/// for the rates and three for the forces is tried. Force is the vector of about 1 g, in m/s^2 or g
/// or times the step, that keeps it when averaged over seconds. Its length is not constant, unlike
/// that of gravity alone. Rates differ from it in size, and their length is not constant either,
/// unlike that of a magnetic field. Rates are not angles, whose rates are in other columns.
ContentFit FitImu(const TextSample& sample);

}  // namespace dn::files_internal
