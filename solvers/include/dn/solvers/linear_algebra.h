#pragma once

namespace dn {

/// Implementation of the sparse Cholesky factorisation and its triangular solutions. Elimination
/// order, pattern of the factor and selected inverse are the same.
enum class LinearAlgebra {
  kMultifrontal,  ///< the multifrontal method of this project; uses several threads
  kCholmod,       ///< CHOLMOD's supernodal factorisation
};

/// Returns kCholmod if the environment variable DN_LINEAR_ALGEBRA is "cholmod", else kMultifrontal.
LinearAlgebra DefaultLinearAlgebra();

}  // namespace dn
