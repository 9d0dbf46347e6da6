#pragma once

#include <dn/network.h>

#include <string>

namespace dn {

/// Returns the first active factor that is undefined or not finite at the current values, or -1.
FactorId FindUndefinedFactor(const Network& network);

/// Returns the message about such a factor. It names the residual row or Jacobian that the factor
/// does not write, if any.
std::string UndefinedFactorMessage(const Network& network, FactorId id);

}  // namespace dn
