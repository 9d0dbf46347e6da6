#pragma once

#include <string>

#include "command.h"

namespace dn::apps {

/// What `dn study --optimise` runs on.
struct LineOptions {
  std::string file;
  std::uint64_t seed = 1;
};

/// Chooses the lines of the shortest flight that meets the target of the file; where none does, the
/// results are written, too.
void RunLineChoice(const LineOptions& options, Run& run);

}  // namespace dn::apps
