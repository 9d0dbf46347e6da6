#pragma once

#include <dn/network_state.h>
#include <dn/solvers/marginals.h>

namespace dn {

/// Adds the covariances of the blocks that `marginals` determine to a state of the same network,
/// and computes the selected inverse for them. Constant blocks get a covariance of zeros.
void AddCovariances(Marginals* marginals, const Network& network, NetworkState* state);

}  // namespace dn
