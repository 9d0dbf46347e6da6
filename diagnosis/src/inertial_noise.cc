#include "inertial_noise.h"

#include <dn/solvers/restricted_likelihood.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>

namespace dn::diagnosis_internal {
namespace {

// A size that is more probable than that of the raw data by less than this is not preferred.
constexpr double kOwnSizeLeadNats = 2.0;

/// Returns the index of the most probable size. The likelihood has one peak over the ascending
/// sizes, and two sizes are evaluated at a time, in parallel.
std::size_t FindLikeliest(VarianceLikelihood& likelihood, const std::vector<double>& thetas) {
  const std::size_t last = thetas.size() - 1;
  if (last == 0) return 0;
  const std::vector<double> end = likelihood.At({thetas[last], thetas[last - 1]});
  if (end[0] >= end[1]) return last;
  double before = -std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < last; k += 2) {
    const std::vector<double> l = likelihood.At({thetas[k], thetas[k + 1]});
    if (l[0] < before) return k - 1;
    if (l[1] < l[0]) return k;
    before = l[1];
  }
  return last - 1;
}

}  // namespace

Eigen::VectorXd InertialShare(const FlightNetwork& network, const LinearizedNetwork& linearized,
                              const PreintegrationNoise& noise) {
  Eigen::VectorXd share = Eigen::VectorXd::Zero(linearized.rows());
  for (const InertialEdge& edge : network.inertial().edges()) {
    const auto rows = linearized.FindRows(edge.id);
    if (!rows) continue;
    const Preintegrated stated = network.inertial().FactorInUse(edge)->increments();
    const Preintegrated part = Preintegrate(*network.flight().imu, stated.t_begin_s, stated.t_end_s,
                                            stated.linearisation, noise);
    // The network whitens by the inverse of the lower Cholesky factor.
    const auto L = stated.covariance.llt();
    const Eigen::MatrixXd half = L.matrixL().solve(part.covariance);
    const Eigen::MatrixXd whitened = L.matrixL().solve(half.transpose());
    share.segment(rows->first, rows->count) = whitened.diagonal().cwiseMax(0.0);
  }
  return share;
}

NetworkSupport FindNetworkSupport(const LinearizedNetwork& linearized, const Eigen::VectorXd& share,
                                  const std::vector<double>& thetas, int threads) {
  VarianceLikelihood likelihood(linearized, share, threads);
  const std::size_t raw = thetas.size() - 1;
  const std::vector<double> l = likelihood.At({0.0, thetas[raw]});
  const double of_raw = l[1] - l[0];
  const std::size_t best = FindLikeliest(likelihood, thetas);
  const double of_best = likelihood.At(thetas[best]) - l[0];
  if (of_best <= of_raw + kOwnSizeLeadNats) return {of_raw, thetas[raw], true};
  // One of several sizes that are equally probable before the data.
  const double selection = std::log(static_cast<double>(thetas.size()));
  return {of_best - selection, thetas[best], false};
}

}  // namespace dn::diagnosis_internal
