#include "flight_identity.h"

#include <algorithm>

#include "calibrate_strips.h"
#include "input_files.h"
#include "output_folder.h"
#include "sha256.h"

namespace dn::apps {

void SetIdentity(const FlightConfig& config, const std::vector<std::string>& changes,
                 ReducedFlight* flight) {
  Inputs inputs = FlightInputs(config.file, changes);
  std::erase(inputs.files, config.file);
  if (HasStripsAlone(config)) inputs.files = inputs.All();
  const Json data = InputFilesJson(inputs);
  flight->data = Sha256Hex(FormatJson(data));
  flight->made_from = Sha256Hex(
      FormatJson({{"dn", DN_VERSION}, {"config", FormatFlightConfig(config)}, {"data", data}}));
}

}  // namespace dn::apps
