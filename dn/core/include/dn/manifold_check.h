#pragma once

#include <dn/block.h>

#include <string>

namespace dn {

/// Checks a kind with functions of its own (kManifold) at a value x on its manifold:
///
///   Plus(x, 0) = x,   Minus(Plus(x, d), x) = d,   PlusJacobian(x) = d Plus(x, d) / d d at d = 0
///
/// for steps d of 0.1, or of 0.001 where a step of 0.1 leaves the domain. Throws InvalidInput that
/// names the block, the function, the coordinate and both numbers. Costs about 20 calls of Plus per
/// tangent coordinate.
void CheckManifold(const BlockKind& kind, const double* x, const std::string& block_name);

}  // namespace dn
