#include <dn/error.h>
#include <dn/solvers/prediction.h>
#include <dn/solvers/robust_loss.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <string>
#include <vector>

namespace dn {
namespace {

/// A factor's whitened residual, and the covariance J C J^T of its model part.
struct Fitted {
  Eigen::VectorXd r;
  Eigen::MatrixXd H;
};

Eigen::MatrixXd Cross(const Marginals& marginals, BlockId a, BlockId b) {
  const auto inside = marginals.PatternBlock(a, b);
  return inside ? *inside : marginals.Covariance(a, b);
}

Fitted Fit(const Network& network, FactorId factor, const Marginals& marginals) {
  const FactorRecord& record = network.factor(factor);
  Fitted fitted;
  std::vector<Eigen::MatrixXd> J;
  if (!network.EvaluateFactor(factor, &fitted.r, &J)) {
    throw InvalidInput("prediction: factor " + std::to_string(factor) +
                       " is undefined at the present values");
  }
  fitted.H = Eigen::MatrixXd::Zero(fitted.r.size(), fitted.r.size());
  for (std::size_t a = 0; a < J.size(); ++a) {
    if (network.block(record.blocks[a]).held) continue;
    fitted.H += J[a] * marginals.DiagonalBlock(record.blocks[a]) * J[a].transpose();
    for (std::size_t b = 0; b < a; ++b) {
      if (network.block(record.blocks[b]).held) continue;
      const Eigen::MatrixXd half =
          J[a] * Cross(marginals, record.blocks[a], record.blocks[b]) * J[b].transpose();
      fitted.H += half + half.transpose();
    }
  }
  return fitted;
}

}  // namespace

Prediction PredictFactor(const Network& network, FactorId factor, const Marginals& marginals) {
  // Share of a residual that the fit leaves, below which the others say nothing about it.
  constexpr double kUndetermined = 1e-9;
  const Fitted fitted = Fit(network, factor, marginals);
  const FactorRecord& record = network.factor(factor);
  const double weight =
      record.active ? EvaluateLoss(record.loss, fitted.r.squaredNorm()).rho_prime : 0.0;
  const Eigen::Index m = fitted.r.size();
  const Eigen::MatrixXd I = Eigen::MatrixXd::Identity(m, m);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> left(I - weight * fitted.H);
  Prediction prediction;
  prediction.determined = left.eigenvalues()[0] > kUndetermined;
  if (!prediction.determined) return prediction;
  const Eigen::MatrixXd inverse = left.eigenvectors() *
                                  left.eigenvalues().cwiseInverse().asDiagonal() *
                                  left.eigenvectors().transpose();
  prediction.residual = inverse * fitted.r;
  const Eigen::MatrixXd product = fitted.H * inverse;  // symmetric but for rounding
  prediction.covariance = I + 0.5 * (product + product.transpose());
  prediction.statistic =
      prediction.residual.dot(prediction.covariance.llt().solve(prediction.residual));
  return prediction;
}

Eigen::VectorXd RedundancyNumbers(const Network& network, FactorId factor,
                                  const Marginals& marginals) {
  if (!network.factor(factor).active) {
    throw InvalidInput("redundancy numbers: factor " + std::to_string(factor) + " is not active");
  }
  return (1.0 - Fit(network, factor, marginals).H.diagonal().array()).cwiseMax(0.0);
}

}  // namespace dn
