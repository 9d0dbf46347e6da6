#pragma once

#include <dn/calibration/finding.h>
#include <dn/calibration/model_check.h>

#include <string>
#include <vector>

namespace dn {

/// "calibrated", "absorbed", "not_observable", "contradicted".
const char* Word(Verdict verdict);

/// Of a trajectory without boresight: "consistent", "contradicted".
const char* Word(const ModelCheck& check);

/// One sentence, without its full stop: what, how much, and what to do.
std::string Words(const Finding& finding);

std::vector<std::string> Words(const std::vector<Finding>& findings);

}  // namespace dn
