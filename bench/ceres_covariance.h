#pragma once

#include <dn/network.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace dn::bench {

/// Covariances of some blocks, in tangent coordinates, as ceres::Covariance gives them.
struct CeresCovariance {
  std::string error;                        ///< empty: it worked
  double time_s = 0.0;                      ///< processor time of ceres::Covariance::Compute
  std::vector<Eigen::MatrixXd> covariance;  ///< one per block asked for
};

/// Runs ceres::Covariance (sparse QR by SuiteSparse, one thread) on the network in a process of its
/// own, which ends after limit_s of processor time; error says so.
CeresCovariance ComputeByCeres(Network& network, const std::vector<BlockId>& blocks,
                               unsigned limit_s);

/// Bound of LargestDifference: two double-precision factorisations (QR of J, Cholesky of J^T J) of
/// the same Jacobian.
inline constexpr double kSameCovariance = 1e-5;

/// Largest difference of two covariances of the same blocks, in units of the sigmas.
double LargestDifference(const std::vector<Eigen::MatrixXd>& a,
                         const std::vector<Eigen::MatrixXd>& b);

}  // namespace dn::bench
