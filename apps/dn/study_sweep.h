#pragma once

#include <string>

#include "command.h"

namespace dn::apps {

/// Options of `dn study --sweep`.
struct SweepOptions {
  std::string file;
  std::string shard = "1/1";
};

/// Studies the designs of a sweep or of a shard of it, one per thread. Designs that are already
/// recorded in --out are skipped.
void RunSweep(const SweepOptions& options, Run& run);

}  // namespace dn::apps
