#pragma once

#include <dn/network.h>

#include <string>
#include <vector>

namespace dn {

/// Options of Eliminate.
struct EliminateOptions {
  std::string name = "eliminated";  ///< name of the group of the prior
  int threads = 1;
};

/// Outcome of Eliminate.
struct Elimination {
  /// The prior that replaces the factors; -1 if they contain no information on other blocks.
  FactorId prior = -1;
  std::vector<BlockId> neighbours;  ///< blocks of the prior, in its order
  int factors = 0;                  ///< number of active factors that it replaces
  /// Least cost of these factors over the eliminated blocks, at the best values of the neighbours.
  double cost = 0.0;
};

/// Removes blocks and all factors on them, and adds one LinearPrior of their neighbours with the
/// same information. Neighbours are the blocks that share an active factor with them:
///
///   R^T R = N_SS - N_SE N_EE^-1 N_ES,    E the eliminated blocks, S the neighbours
///
/// at the present values and robust weights. A network with linear factors keeps its solution and
/// its covariances exactly. Otherwise the prior is exact at the present values, so eliminate blocks
/// of a solved network. SolveSummary::warnings says if later measurements have moved the neighbours
/// so far that the difference counts.
///
/// A finished part of a trajectory, a flight or a day can so be replaced. A growing chain that
/// keeps its last nodes then costs the same for each new node. Constant blocks are not neighbours.
/// Throws RankDeficient if the neighbours do not determine the blocks, and InvalidInput for a
/// factor that is undefined; the network is then unchanged.
Elimination Eliminate(Network* network, const std::vector<BlockId>& blocks,
                      const EliminateOptions& options = {});

/// A prior of Eliminate whose linearisation no longer represents the eliminated factors.
struct MovedPrior {
  FactorId factor = -1;
  double sigmas = 0.0;  ///< movement of its blocks since the elimination, in sigmas of the prior
  double error = 0.0;   ///< estimated change of the residual of the prior by it, sigmas
  std::string text;
};

/// Returns the priors whose estimated error exceeds `error` sigmas at the present values.
std::vector<MovedPrior> FindMovedPriors(const Network& network, double error = 0.1);

}  // namespace dn
