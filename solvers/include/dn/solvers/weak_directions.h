#pragma once

#include <dn/solvers/marginals.h>

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

namespace dn {

/// The part of one unknown, over all its epochs, in a direction of the unknowns.
struct UnknownShare {
  std::string name;  ///< "boresight pitch", by the labels of the blocks
  double weight =
      0.0;  ///< rms over the epochs that take part; of all unknowns the squares sum to 1
  double first_s = 0.0, last_s = 0.0;  ///< epochs that take part; first > last: it has none
};

/// A direction of the unknowns that the measurements determine weakly.
struct WeakDirection {
  /// Eigenvalue of the normal matrix that is scaled to a unit diagonal: 1 where the unknowns of the
  /// direction are determined by themselves, far below where only differences or sums of them are.
  double information = 0.0;
  /// What one sigma of the direction is, by block, in its tangent coordinates (SI units, rad). The
  /// sign is arbitrary; of all directions together the products sum to the covariance.
  std::map<BlockId, Eigen::VectorXd> one_sigma;
  std::vector<UnknownShare> shares;  ///< the largest first; those below a tenth of it are left out
  std::string text;  ///< "position east, 100.0..200.0 s (0.71), antenna east (0.71)"
};

/// The k directions about which the measurements say least, the weakest first: eigenvectors of
/// scale N scale, scale = diag(N)^(-1/2). Fewer where there are fewer unknowns. Directions that the
/// measurements leave free altogether do not occur: Marginals refuses them. Throws InvalidInput
/// for k < 1.
///
/// By inverse iteration of blocks of vectors, some ten pairs of triangular solves for each
/// direction; eigenvalues to about 1e-10 of their size where they stand apart from those beyond
/// the k-th, and never below what the direction that is given has.
std::vector<WeakDirection> WeakDirections(const Marginals& marginals, int k);

}  // namespace dn
