#pragma once

#include <dn/network.h>

#include <Eigen/Core>
#include <optional>
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
/// own, which ends after limit_s of processor time; error says so. The tangent of every block is
/// divided by its entry of `sigma` (tangent sized, by block id) and multiplied again afterwards:
/// without that its rank test rejects networks that mix metres and radians.
CeresCovariance ComputeByCeres(Network& network, const std::vector<BlockId>& blocks,
                               const std::vector<Eigen::VectorXd>& sigma, unsigned limit_s);

}  // namespace dn::bench
