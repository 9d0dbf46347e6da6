#pragma once

#include <dn/geo/local_frame.h>
#include <dn/lidar/swath.h>

#include <vector>

#include "command.h"

namespace dn::apps {

/// Returns whether the files of AddSwathFiles are staged already.
bool HasSwathFiles(Run& run);

/// Stages swaths.json and swaths.geojson.
void AddSwathFiles(const std::vector<Swath>& swaths, const LocalFrame& frame, Run* run);

}  // namespace dn::apps
