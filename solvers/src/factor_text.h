#pragma once

#include <dn/network.h>

#include <string>

namespace dn {

/// The first active factor that is undefined, or not finite, at the current values; -1 if none.
FactorId FindUndefinedFactor(const Network& network);

/// The message about such a factor; names what it does not write.
std::string UndefinedFactorMessage(const Network& network, FactorId id);

}  // namespace dn
