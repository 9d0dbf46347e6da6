#pragma once

#include <dn/flight/flight_config.h>

#include <string>
#include <vector>

namespace dn {

/// The first strip that t_s lies in, both ends included; null where there is none.
const StripInterval* StripAt(const std::vector<StripInterval>& strips, double t_s);

/// Names of the strips that the two epochs of a pair lie in: "1-2"; "?" for none.
std::string StripPairName(const std::vector<StripInterval>& strips, double t_i_s, double t_j_s);

/// The same of strips; null: none.
std::string StripPairName(const StripInterval* i, const StripInterval* j);

}  // namespace dn
