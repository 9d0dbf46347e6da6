#include <dn/error.h>
#include <dn/solvers/prediction.h>
#include <dn/symmetric_eigen.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <string>

namespace dn {
namespace {

Eigen::MatrixXd Cross(const Marginals& marginals, BlockId a, BlockId b) {
  const auto inside = marginals.PatternBlock(a, b);
  return inside ? *inside : marginals.Covariance(a, b);
}

/// J C J^T of a factor, without its robust weight.
Eigen::MatrixXd ModelCovariance(const Marginals& marginals,
                                const LinearizedNetwork::Factor& factor) {
  const auto& J = factor.jacobian;
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(factor.residual.size(), factor.residual.size());
  for (std::size_t a = 0; a < J.size(); ++a) {
    H += J[a].second * marginals.DiagonalBlock(J[a].first) * J[a].second.transpose();
    for (std::size_t b = 0; b < a; ++b) {
      const Eigen::MatrixXd half =
          J[a].second * Cross(marginals, J[a].first, J[b].first) * J[b].second.transpose();
      H += half + half.transpose();
    }
  }
  return H;
}

/// Whether it is unknowns of the network alone that the factor depends on.
bool DependsOnUnknowns(const LinearizedNetwork& linearized,
                       const LinearizedNetwork::Factor& factor) {
  return std::all_of(factor.jacobian.begin(), factor.jacobian.end(), [&](const auto& of_block) {
    return linearized.FirstColumn(of_block.first) >= 0;
  });
}

}  // namespace

Prediction PredictFactor(const Marginals& marginals, FactorId id) {
  // Share of a residual that the fit leaves, below which the others say nothing about it.
  constexpr double kUndetermined = 1e-9;
  const LinearizedNetwork::Factor factor = marginals.linearized().FactorAt(id);
  Prediction prediction;
  prediction.determined = DependsOnUnknowns(marginals.linearized(), factor);
  if (!prediction.determined) return prediction;
  const Eigen::MatrixXd H = ModelCovariance(marginals, factor);
  const Eigen::Index m = factor.residual.size();
  const Eigen::MatrixXd I = Eigen::MatrixXd::Identity(m, m);
  const SymmetricEigen left(I - factor.weight * H);
  prediction.determined = left.values[0] > kUndetermined;
  if (!prediction.determined) return prediction;
  const Eigen::MatrixXd inverse =
      left.vectors * left.values.cwiseInverse().asDiagonal() * left.vectors.transpose();
  prediction.residual = inverse * factor.residual;
  const Eigen::MatrixXd product = H * inverse;  // symmetric but for rounding
  prediction.covariance = I + 0.5 * (product + product.transpose());
  prediction.statistic =
      prediction.residual.dot(prediction.covariance.llt().solve(prediction.residual));
  return prediction;
}

Eigen::VectorXd RedundancyNumbers(const Marginals& marginals, FactorId id) {
  if (!marginals.linearized().RowsOf(id)) {
    throw InvalidInput("redundancy numbers: factor " + std::to_string(id) + " is not active");
  }
  const LinearizedNetwork::Factor factor = marginals.linearized().FactorAt(id);
  const Eigen::ArrayXd share = factor.weight * ModelCovariance(marginals, factor).diagonal();
  return (1.0 - share).cwiseMax(0.0);
}

Eigen::VectorXd RedundancyNumbers(const Marginals& marginals) {
  const LinearizedNetwork& linearized = marginals.linearized();
  Eigen::VectorXd redundancy(linearized.rows());
  for (const LinearizedNetwork::FactorRows& rows : linearized.factors()) {
    redundancy.segment(rows.first, rows.count) = RedundancyNumbers(marginals, rows.factor);
  }
  return redundancy;
}

}  // namespace dn
