#pragma once

#include <dn/report/document.h>

#include <string>
#include <vector>

#include "result_folder.h"

namespace dn::internal {

/// One boresight of a result folder.
struct Calibrated {
  std::string suffix;  ///< of its files: "", "_dn", "_gh"
  Facts result;
};

/// Those that a folder has, that of the network first.
std::vector<Calibrated> CalibrationsIn(const ResultFolder& folder);

/// The headline of one; `with_name` where there are several.
Headline HeadlineOf(const Calibrated& calibrated, bool with_name);

/// The difference of each two, its sigma and significance.
Table DifferenceTable(const std::vector<std::pair<std::string, Facts>>& named);

}  // namespace dn::internal
