#pragma once

#include <dn/adjustment/finding.h>

#include <string>
#include <vector>

namespace dn {

/// Returns "calibrated", "absorbed", "not_observable" or "contradicted".
const char* Word(Verdict verdict);

/// These functions return one sentence per finding, without its full stop: what is wrong, by how
/// much, and what to do.
std::string Words(const Finding& finding);

std::vector<std::string> Words(const std::vector<Finding>& findings);

}  // namespace dn
