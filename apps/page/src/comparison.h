#pragma once

#include <filesystem>
#include <vector>

#include "calibration.h"

namespace dn::internal {

/// Returns a page that compares several results.
Document ComparisonPage(const std::vector<std::filesystem::path>& folders);

}  // namespace dn::internal
