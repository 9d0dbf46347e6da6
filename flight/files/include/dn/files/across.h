#pragma once

#include <dn/config/yaml_value.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// Section `across` of flight.yaml: the unknowns that several flights of one calibration share. It
/// is not a part of FlightConfig, because a single flight does not depend on it.
struct AcrossConfig {
  /// Change of the boresight from each flight to the next: standard deviation of its angles, rad.
  /// Absent: the boresight is constant over all flights.
  std::optional<double> walk_rad = {};
  bool walk_estimated = false;  ///< true: the size of the change is estimated
  /// Effects under `estimate` that have one value for all flights.
  std::vector<std::string> unknowns = {};

  bool operator==(const AcrossConfig&) const = default;
};

/// Reads the value of `across`; that of an absent value is one constant boresight. Throws
/// InvalidConfig for a name that is not the boresight or a fixed effect of a whole flight. Also
/// throws for a name that occurs twice, and for a list without the boresight.
AcrossConfig ParseAcross(const YamlValue& value);

/// Reads the section `across` of a flight.yaml. Throws InvalidConfig as ReadFlightConfig does.
AcrossConfig ReadAcross(const std::filesystem::path& folder_or_file);

/// Returns the value of `across` as YAML on one line.
std::string FormatAcross(const AcrossConfig& across);

}  // namespace dn
