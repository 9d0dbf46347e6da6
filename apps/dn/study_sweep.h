#pragma once

#include <string>

#include "command.h"

namespace dn::apps {

/// What `dn study --sweep` runs on.
struct SweepOptions {
  std::string file;
  std::string shard = "1/1";
};

/// Studies the designs of a sweep, or of a shard of it, one on each thread; those that are recorded
/// in --out already are not studied again.
void RunSweep(const SweepOptions& options, Run& run);

}  // namespace dn::apps
