#pragma once

#include <dn/network.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace ceres {
class Problem;
}  // namespace ceres

namespace dn::bench {

/// Covariances of some blocks in tangent coordinates, as computed by ceres::Covariance.
struct CeresCovariance {
  std::string error;                        ///< empty on success
  double time_s = 0.0;                      ///< processor time of ceres::Covariance::Compute
  std::vector<Eigen::MatrixXd> covariance;  ///< one per requested block
};

/// Returns the processor time of this process, s.
double ProcessorSeconds();

/// Runs ceres::Covariance (SuiteSparse sparse QR, one thread) on parameter blocks of a problem in a
/// separate process. The process is ended after limit_s of processor time, which `error` then
/// reports.
CeresCovariance ComputeByCeres(ceres::Problem& problem, const std::vector<const double*>& blocks,
                               unsigned limit_s);

/// Does the same for blocks of a network.
CeresCovariance ComputeByCeres(Network& network, const std::vector<BlockId>& blocks,
                               unsigned limit_s);

/// Bound of LargestDifference for two double-precision factorisations of the same Jacobian (QR of
/// J, Cholesky of J^T J).
inline constexpr double kSameCovariance = 1e-5;

/// Returns the largest difference of two covariances of the same blocks, in units of the sigmas.
double LargestDifference(const std::vector<Eigen::MatrixXd>& a,
                         const std::vector<Eigen::MatrixXd>& b);

}  // namespace dn::bench
