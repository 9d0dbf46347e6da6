#pragma once

#include <dn/solvers/marginals.h>

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

namespace dn {

/// Share of one unknown, over all its epochs, in a direction of the unknowns.
struct UnknownShare {
  std::string name;  ///< for example "boresight pitch", from the labels of the blocks
  /// rms over the contributing epochs; the squares over all unknowns sum to 1.
  double weight = 0.0;
  /// Range of the contributing epochs; first > last if the unknown has no epochs.
  double first_s = 0.0, last_s = 0.0;
};

/// A direction of the unknowns that the measurements determine weakly.
struct WeakDirection {
  /// Eigenvalue of the normal matrix scaled to a unit diagonal. It is 1 if the unknowns of the
  /// direction are determined independently, and far below 1 if only their sums or differences are
  /// determined.
  double information = 0.0;
  /// One-sigma vector of the direction, by block, in tangent coordinates (SI units, rad). The sign
  /// is arbitrary. Summed over all directions, the outer products give the covariance.
  std::map<BlockId, Eigen::VectorXd> one_sigma;
  /// Largest first; shares below a tenth of the largest are omitted.
  std::vector<UnknownShare> shares;
  std::string text;  ///< for example "position east, 100.0..200.0 s (0.71), antenna east (0.71)"
};

/// Returns the k directions with the least information, weakest first: eigenvectors of scale N
/// scale, scale = diag(N)^(-1/2). Returns fewer if there are fewer unknowns. Directions that the
/// measurements leave undetermined do not occur, because Marginals throws for them. Throws
/// InvalidInput for k < 1.
///
/// Uses block inverse iteration, with about ten pairs of triangular solves per direction. The
/// eigenvalues are accurate to about 1e-10 of their size if they are separated from those beyond
/// the k-th. They are never below the information of the returned direction.
std::vector<WeakDirection> WeakDirections(const Marginals& marginals, int k);

}  // namespace dn
