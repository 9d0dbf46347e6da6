#pragma once

#include <optional>
#include <string_view>

#include "content_fit.h"
#include "picked_columns.h"
#include "text_sample.h"

namespace dn::files_internal {

/// Fits a text to GNSS positions in latitude, longitude (in any order) and height. Without names in
/// a header they follow the time, and the number of columns says whether sigmas and velocities
/// follow.
ContentFit FitGnss(const TextSample& sample);

/// Finds the positions in a file of inertial data, whose time is given: columns with names. They
/// may be empty, 0, or repeated in rows without a new position. Positions that change at a
/// higher rate than that of receivers are the output of a filter, and not found.
std::optional<FileContent> FindGnssBesideImu(const TextSample& sample, const TimeColumn& time);

/// Returns whether the header names latitude and longitude, but no rates and forces.
bool NamesPosition(const TextSample& sample);

/// Returns the format of a file that begins with these lines. It is NMEA if one of them is a GGA or
/// RMC sentence. It is RTKLIB if one is the header of a solution, or the row of a solution without
/// header.
std::optional<GnssFormat> FindGnssFormat(std::string_view beginning);

}  // namespace dn::files_internal
