#pragma once

#include <dn/diagnosis/diagnose.h>

#include <string>
#include <vector>

namespace dn::diagnosis_internal {

/// Returns a result with the verdict `unavailable`, for the reason `missing`.
GapResult Unavailable(const Flight& flight, const GapOptions& options, const std::string& missing);

/// Returns a result with detection limits and without a verdict.
GapResult WithLimits(const Flight& flight, GapDiagnosis diagnosis);

/// Returns the effects that a given trajectory contains: they are undetectable at any size.
std::vector<DetectionLimit> EffectsInTrajectory(const GapOptions& options);

}  // namespace dn::diagnosis_internal
