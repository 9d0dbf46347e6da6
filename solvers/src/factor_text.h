#pragma once

#include <dn/network.h>

#include <string>

namespace dn {

/// "factor 12 (gnss position, 381000.200 s)", for messages.
std::string DescribeFactor(const Network& network, FactorId id);

/// The first active factor that is undefined, or not finite, at the current values; -1 if none.
FactorId FindUndefinedFactor(const Network& network);

/// The message about such a factor.
std::string UndefinedFactorMessage(const Network& network, FactorId id);

}  // namespace dn
