#pragma once

#include <Eigen/Core>
#include <string>

#include "normal_equations.h"
#include "sparse_cholesky.h"

namespace dn {

/// Directions of the scaled unknowns y (x = scale * y, component by component) in ascending order
/// of their information |J scale v|^2, which is computed through J: N = J^T J would hide what is
/// below 1e-16 of it.
struct WeakDirections {
  Eigen::MatrixXd v;  ///< orthonormal columns
  Eigen::VectorXd information;
};

/// Upper bound of the smallest information, quickly: inverse iteration with the factor of the
/// scaled normal matrix. A free direction shows as a value near rounding.
double ProbeInformation(const Linearization& linearization, const Eigen::VectorXd& scale,
                        const SparseCholesky& cholesky);

/// The (at most eight) weakest directions, by inverse subspace iteration with a slightly shifted
/// matrix. Leaves the shifted factor in `cholesky`.
WeakDirections FindWeakDirections(const Linearization& linearization, const Eigen::VectorXd& scale,
                                  const SymmetricCsc& scaled_N, SparseCholesky& cholesky);

/// What a RankDeficient says of directions of the scaled unknowns (columns of v).
std::string DescribeFreeDirections(const Network& network, const UnknownLayout& layout,
                                   const Eigen::MatrixXd& v);

}  // namespace dn
