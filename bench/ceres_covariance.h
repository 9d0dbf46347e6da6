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

}  // namespace dn::bench
