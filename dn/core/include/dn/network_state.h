#pragma once

#include <dn/network.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace dn {

/// Values, covariances and priors of a network by the names of its blocks. It passes the result of
/// an adjustment to another program, another day or a restart. dn/report/network_file.h reads and
/// writes it.
struct NetworkState {
  struct Block {
    std::string name;
    Parametrisation parametrisation = Parametrisation::kVector;
    Eigen::VectorXd value;       ///< stored numbers; quaternions as x, y, z, w
    Eigen::MatrixXd covariance;  ///< in the tangent, SI units and rad; 0 x 0 if it is not known
  };
  /// A LinearPrior.
  struct Prior {
    std::string group;
    std::vector<std::string> blocks;
    Eigen::VectorXd center;
    Eigen::MatrixXd R;
    Eigen::VectorXd d;
    double nonlinearity = 0.0;
  };
  std::vector<Block> blocks;
  std::vector<Prior> priors;

  /// Returns the block with this name. Throws InvalidInput naming the nearest if there is none.
  const Block& Find(const std::string& name) const;
};

/// Returns the values of all blocks and the active LinearPriors of a network, without covariances;
/// dn/solvers/state_covariance.h adds these.
NetworkState GetState(const Network& network);

/// Sets the values of the blocks with the names of the state, and adds its priors. Blocks that only
/// the network has keep their values. Throws InvalidInput naming the block if the network has no
/// block of that name and kind; the network is then unchanged.
void SetState(const NetworkState& state, Network* network);

/// Adds the value and covariance of a block of a state as a LinearPrior of the block with this
/// name. Returns the id of the prior. Throws InvalidInput if the network has no block of that name
/// and kind, or if the covariance is not positive definite.
FactorId AddPrior(const NetworkState::Block& block, Network* network);

}  // namespace dn
