#pragma once

#include <string>

#include "command.h"

namespace dn::apps {

/// Options of `dn study --optimise`.
struct LineOptions {
  std::string file;
  std::uint64_t seed = 1;
};

/// Chooses the lines of the shortest flight that meets the target in the file. Results are also
/// written if no choice meets the target.
void RunLineChoice(const LineOptions& options, Run& run);

}  // namespace dn::apps
