#pragma once

#include <dn/gap/diagnose.h>

#include <string>
#include <vector>

namespace dn::internal {

/// The diagnosis of a flight that cannot carry one, with what is missing.
GapResult Unavailable(const Flight& flight, const GapOptions& options, const std::string& missing);

/// The answer to what could be found, without a verdict.
GapResult WithLimits(const Flight& flight, GapDiagnosis diagnosis);

/// Effects that come with a trajectory that is given: of any size.
std::vector<HiddenEffect> HiddenByTrajectory(const GapOptions& options);

}  // namespace dn::internal
