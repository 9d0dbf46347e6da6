#pragma once

#include <dn/flight/estimate.h>

#include <string>
#include <vector>

namespace dn {

/// Fixed effects that the network has as unknowns.
std::vector<std::string> EstimableEffects();

/// Throws InvalidConfig, naming the entry's place, for a fixed effect that the network does not
/// have as an unknown.
void CheckEstimable(const std::vector<EstimateEntry>& estimate);

}  // namespace dn
