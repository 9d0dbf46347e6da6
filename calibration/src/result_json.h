#pragma once

#include <dn/calibration/result_files.h>

#include <vector>

namespace dn::internal {

/// Sections of result.json that all methods have.
Json BoresightJson(const BoresightResult& boresight);
Json AssessmentJson(const BoresightResult& boresight);
Json UnknownsJson(const std::vector<UnknownEstimate>& unknowns);
Json TimingJson(const RunTimings& timings);

}  // namespace dn::internal
