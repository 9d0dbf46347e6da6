#include <dn/solvers/state_covariance.h>

namespace dn {

void AddCovariances(Marginals* marginals, const Network& network, NetworkState* state) {
  marginals->ComputeSelectedInverse();
  for (NetworkState::Block& block : state->blocks) {
    const BlockId id = network.Find(block.name);
    const bool determined = network.block(id).held || marginals->linearized().FirstColumn(id) >= 0;
    if (determined) block.covariance = marginals->Covariance(id);
  }
}

}  // namespace dn
