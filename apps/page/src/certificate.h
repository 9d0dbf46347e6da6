#pragma once

#include <dn/report/document.h>

#include <vector>

#include "calibration.h"
#include "result_folder.h"

namespace dn::page_internal {

/// Returns the certificate that a calibration prints instead of its page, on two sheets of paper.
/// It has the verdict, angles with sigmas, covariance, sensors, control by pairs, and hashes of the
/// inputs. `calibrated` is the result to use.
std::vector<Section> Certificate(const ResultFolder& folder, const Calibrated& calibrated);

}  // namespace dn::page_internal
