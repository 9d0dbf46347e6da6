#pragma once

#include <dn/config/yaml_value.h>
#include <dn/files/flight_config.h>

#include <string>
#include <vector>

namespace dn::files_internal {

/// Reads the sections `lidar`, `pairs_between` and `scanner` of flight.yaml into a configuration:
/// one scanner, or a list of them; `scanner` selects one of the list. Returns the names of all
/// scanners of the list. Throws InvalidConfig for a name that occurs twice or is not plain, and for
/// a scanner that is not in the list.
std::vector<std::string> ReadScanners(const YamlValue& root, FlightConfig* config);

}  // namespace dn::files_internal
