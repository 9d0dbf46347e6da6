#pragma once

#include <filesystem>
#include <vector>

#include "calibration.h"

namespace dn::page_internal {

/// Returns a page that compares several results.
Document ComparisonPage(const std::vector<std::filesystem::path>& folders);

}  // namespace dn::page_internal
