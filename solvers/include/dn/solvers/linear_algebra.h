#pragma once

namespace dn {

/// Implementation of the sparse Cholesky factorisation and its triangular solutions. The elimination
/// order, the pattern of the factor and the selected inverse are the same.
enum class LinearAlgebra {
  kMultifrontal,  ///< the multifrontal method of this project; uses several threads
  kCholmod,       ///< CHOLMOD's supernodal factorisation
};

/// Returns kCholmod if the environment variable DN_LINEAR_ALGEBRA is "cholmod", else kMultifrontal.
LinearAlgebra DefaultLinearAlgebra();

}  // namespace dn
