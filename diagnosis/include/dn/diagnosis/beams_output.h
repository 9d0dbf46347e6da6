#pragma once

#include <dn/adjustment/beams.h>
#include <dn/files/flight_config.h>
#include <dn/lidar/beam_errors.h>
#include <dn/report/json.h>

#include <optional>
#include <string>
#include <vector>

namespace dn {

/// Returns the errors of the observable beams of the only scanner; those of the others are 0.
/// Returns nullopt without beams.
std::optional<BeamErrors> ObservedErrors(const std::vector<BeamCorrections>& beams,
                                         const LidarConfig& lidar);

/// Adds `beams` to a result file: a list with an element per scanner. Each has the number of ends
/// of pairs of each beam. For `angle` and `range_offset` it has value, sigma, sigma of the prior
/// and whether it is observable. The value of a beam that is not observable is null. Adds nothing
/// without beams. Without values, for a study, there are only sigmas.
void AddBeamsJson(const std::vector<BeamCorrections>& beams, bool with_values, Json* json);

/// Returns a table of the corrections with their sigmas, and names the beams that are not
/// observable; empty without beams.
std::string BeamsSummary(const std::vector<BeamCorrections>& beams, bool with_values);

}  // namespace dn
