#pragma once

#include <dn/solvers/weak_directions.h>

#include <Eigen/Core>
#include <string>
#include <vector>

#include "linearized_impl.h"
#include "sparse/sparse.h"

namespace dn {

/// Directions of the scaled unknowns y (x = scale * y, component by component) in ascending order
/// of their information |J scale v|^2. The information is computed through J, because N = J^T J
/// loses anything below 1e-16 of its largest eigenvalue.
struct ScaledDirections {
  Eigen::MatrixXd v;  ///< orthonormal columns
  Eigen::VectorXd information;
};

/// Returns an upper bound of the smallest information, by a few inverse iterations with the factor
/// of the scaled normal matrix. An undetermined direction gives a value near rounding error.
double ProbeInformation(const Linearization& linearization, const Eigen::VectorXd& scale,
                        const sparse::Cholesky& cholesky);

/// Returns the weakest directions (at most eight) of a matrix that may be singular, by inverse
/// subspace iteration with a slightly shifted matrix. `cholesky` contains the shifted factor
/// afterwards.
ScaledDirections FindFreeDirections(const Linearization& linearization,
                                    const Eigen::VectorXd& scale,
                                    const sparse::SymmetricCsc& scaled_N,
                                    sparse::Cholesky& cholesky);

/// Returns the k weakest directions of a matrix whose factor is available, by inverse iteration
/// over blocks of vectors. Their information is accurate to about 1e-10 of its size.
ScaledDirections FindWeakestDirections(const Linearization& linearization,
                                       const Eigen::VectorXd& scale,
                                       const sparse::Cholesky& cholesky, Eigen::Index k);

/// Returns the unknowns that contribute to a direction, largest first, combined by name over all
/// epochs.
std::vector<UnknownShare> ComputeUnknownShares(const LinearizedNetwork::Impl& network,
                                               const Eigen::VectorXd& v);

/// Formats shares, for example "boresight pitch (0.71), gyro bias y, 100.0..200.0 s (0.70)".
std::string DescribeShares(const std::vector<UnknownShare>& shares);

/// Returns the text of a RankDeficient about undetermined directions of the scaled unknowns
/// (columns of v).
std::string DescribeFreeDirections(const LinearizedNetwork::Impl& network,
                                   const Eigen::MatrixXd& v);

}  // namespace dn
