#pragma once

#include <filesystem>
#include <vector>

#include "calibration.h"

namespace dn::internal {

/// Several results side by side.
Document ComparisonPage(const std::vector<std::filesystem::path>& folders);

}  // namespace dn::internal
