#pragma once

#include <dn/files/flight.h>
#include <dn/files/strip_agreement.h>

#include <filesystem>
#include <optional>
#include <string>

#include "rough_path.h"

namespace dn::apps {

/// Returns the path of a flight: its trajectory, else a level body along the GNSS positions.
std::optional<RoughPath> KnownPath(const Flight& flight);

/// Compares the first points of a strip with the path of the flight. with_vectors: laser vectors of
/// the file are used; they need the mounting in flight.yaml. Returns nullopt if the points agree or
/// cannot be read.
std::optional<StripDisagreement> CompareStrip(const std::filesystem::path& file,
                                              const FlightConfig& config, const RoughPath& path,
                                              bool with_vectors);

}  // namespace dn::apps
