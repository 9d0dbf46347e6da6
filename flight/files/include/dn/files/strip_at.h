#pragma once

#include <dn/files/flight_config.h>

#include <string>
#include <vector>

namespace dn {

/// Returns the first strip that contains t_s, both ends included; null if there is none.
const StripInterval* StripAt(const std::vector<StripInterval>& strips, double t_s);

/// Returns the names of the strips that contain the two epochs of a pair: "1-2"; "?" for an epoch
/// outside of all strips.
std::string StripPairName(const std::vector<StripInterval>& strips, double t_i_s, double t_j_s);

/// Returns the names of two strips in this form; null gives "?".
std::string StripPairName(const StripInterval* i, const StripInterval* j);

}  // namespace dn
