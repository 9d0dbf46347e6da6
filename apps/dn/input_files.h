#pragma once

#include <dn/report/json.h>

#include "output_folder.h"

namespace dn::apps {

/// What identifies the files that a command reads: [{"file", "bytes", "sha256"}], each once, named
/// relative to the flight where it lies in it. Files are read in pieces; of what cannot be read there
/// is no element. Throws Interrupted when a signal came.
Json InputFilesJson(const Inputs& inputs);

}  // namespace dn::apps
