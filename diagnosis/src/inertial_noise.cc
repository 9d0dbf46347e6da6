#include "inertial_noise.h"

#include <dn/solvers/restricted_likelihood.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace dn::diagnosis_internal {
namespace {

// A size that is more probable than that of the raw data by less than this is not preferred.
constexpr double kOwnSizeLeadNats = 2.0;

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
  std::vector<double> with_stated = thetas;
  with_stated.push_back(0.0);
  const std::vector<double> l = likelihood.At(with_stated);
  const auto best = static_cast<std::size_t>(
      std::max_element(l.begin(), l.begin() + static_cast<std::ptrdiff_t>(thetas.size())) -
      l.begin());
  const std::size_t raw = thetas.size() - 1;
  if (l[best] <= l[raw] + kOwnSizeLeadNats) return {l[raw] - l.back(), thetas[raw], true};
  // One of several sizes that are equally probable before the data.
  const double selection = std::log(static_cast<double>(thetas.size()));
  return {l[best] - l.back() - selection, thetas[best], false};
}

}  // namespace dn::diagnosis_internal
