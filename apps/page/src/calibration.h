#pragma once

#include <dn/report/document.h>

#include <string>
#include <vector>

#include "result_folder.h"

namespace dn::page_internal {

/// A boresight of a result folder.
struct Calibrated {
  std::string suffix;  ///< suffix of its files: "", "_dn", "_gh"
  Facts result;
};

/// Returns the boresights of a folder, that of the network first.
std::vector<Calibrated> CalibrationsIn(const ResultFolder& folder);

/// Returns the headline of a boresight. `with_name` adds the method, for folders with several.
Headline CalibrationHeadline(const Calibrated& calibrated, bool with_name);

/// Returns the difference of each two boresights, its sigma and its significance.
Table DifferenceTable(const std::vector<std::pair<std::string, Facts>>& named);

}  // namespace dn::page_internal
