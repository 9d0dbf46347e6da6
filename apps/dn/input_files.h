#pragma once

#include <dn/report/json.h>

#include "output_folder.h"

namespace dn::apps {

/// Returns name, size and hash of each file that a command reads: [{"file", "bytes", "sha256"}].
/// Files in the flight folder have names relative to it. Unreadable files are left out. Throws
/// Interrupted after a signal.
Json InputFilesJson(const Inputs& inputs);

}  // namespace dn::apps
