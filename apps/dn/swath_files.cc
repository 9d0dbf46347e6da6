#include "swath_files.h"

#include <dn/adjustment/map_layers.h>
#include <dn/adjustment/swaths.h>
#include <dn/names.h>

namespace dn::apps {

bool HasSwathFiles(Run& run) { return HasName(run.files().staged(), "swaths.json"); }

void AddSwathFiles(const std::vector<Swath>& swaths, const LocalFrame& frame, Run* run) {
  run->AddFile("swaths.json", FormatSwaths(swaths));
  run->AddFile("swaths.geojson", FormatSwathLayer(swaths, frame));
}

}  // namespace dn::apps
