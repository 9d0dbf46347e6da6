#pragma once

#include <dn/solvers/weak_directions.h>

#include <Eigen/Core>
#include <string>
#include <vector>

#include "linearized_impl.h"
#include "normal_equations.h"
#include "sparse_cholesky.h"

namespace dn {

/// Directions of the scaled unknowns y (x = scale * y, component by component) in ascending order
/// of their information |J scale v|^2, which is computed through J: N = J^T J would hide what is
/// below 1e-16 of it.
struct ScaledDirections {
  Eigen::MatrixXd v;  ///< orthonormal columns
  Eigen::VectorXd information;
};

/// Upper bound of the smallest information, quickly: inverse iteration with the factor of the
/// scaled normal matrix. A free direction shows as a value near rounding.
double ProbeInformation(const Linearization& linearization, const Eigen::VectorXd& scale,
                        const SparseCholesky& cholesky);

/// The (at most eight) weakest directions of a matrix that may be singular, by inverse subspace
/// iteration with a slightly shifted matrix. Leaves the shifted factor in `cholesky`.
ScaledDirections FindFreeDirections(const Linearization& linearization,
                                    const Eigen::VectorXd& scale, const SymmetricCsc& scaled_N,
                                    SparseCholesky& cholesky);

/// The k weakest directions of a matrix whose factor is at hand, to about 1e-10 of their
/// information, by inverse iteration over blocks of vectors.
ScaledDirections FindWeakestDirections(const Linearization& linearization,
                                       const Eigen::VectorXd& scale, const SparseCholesky& cholesky,
                                       Eigen::Index k);

/// The unknowns that take part in a direction, the largest first: by their names, over all epochs.
std::vector<UnknownShare> SharesOf(const LinearizedNetwork::Impl& network,
                                   const Eigen::VectorXd& v);

/// "boresight pitch (0.71), gyro bias y, 100.0..200.0 s (0.70)"
std::string DescribeShares(const std::vector<UnknownShare>& shares);

/// What a RankDeficient says of directions of the scaled unknowns (columns of v).
std::string DescribeFreeDirections(const LinearizedNetwork::Impl& network,
                                   const Eigen::MatrixXd& v);

}  // namespace dn
