#include <dn/error.h>
#include <dn/parallel.h>
#include <dn/solvers/prediction.h>
#include <dn/symmetric_eigen.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace dn {
namespace {

Eigen::MatrixXd Cross(const Marginals& marginals, BlockId a, BlockId b) {
  const auto inside = marginals.SelectedCovariance(a, b);
  return inside ? *inside : marginals.Covariance(a, b);
}

/// Returns the joint covariance of the blocks of a factor.
Eigen::MatrixXd Joint(const Marginals& marginals, const std::vector<BlockId>& blocks,
                      const std::vector<Eigen::Index>& first) {
  if (auto inside = marginals.JointSelectedCovariance(blocks)) return *std::move(inside);
  Eigen::MatrixXd C(first.back(), first.back());
  for (std::size_t a = 0; a < blocks.size(); ++a) {
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      C.block(first[a], first[b], first[a + 1] - first[a], first[b + 1] - first[b]) =
          a == b ? marginals.DiagonalBlock(blocks[a]) : Cross(marginals, blocks[a], blocks[b]);
    }
  }
  return C;
}

/// Returns J C J^T of a factor, without its robust weight.
Eigen::MatrixXd ModelCovariance(const Marginals& marginals,
                                const LinearizedNetwork::Factor& factor) {
  std::vector<BlockId> blocks;
  std::vector<Eigen::Index> first{0};
  for (const auto& [block, jacobian] : factor.jacobian) {
    blocks.push_back(block);
    first.push_back(first.back() + jacobian.cols());
  }
  Eigen::MatrixXd J(factor.residual.size(), first.back());
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    J.middleCols(first[k], first[k + 1] - first[k]) = factor.jacobian[k].second;
  }
  return J * Joint(marginals, blocks, first) * J.transpose();
}

/// Returns true if every block of the factor is constant or an unknown of the network.
bool DependsOnUnknowns(const LinearizedNetwork& linearized,
                       const LinearizedNetwork::Factor& factor) {
  return std::all_of(factor.jacobian.begin(), factor.jacobian.end(), [&](const auto& of_block) {
    return linearized.FirstColumn(of_block.first) >= 0;
  });
}

}  // namespace

Prediction PredictFactor(const Marginals& marginals, FactorId id) {
  // Redundancy below which the other factors do not determine the residual.
  constexpr double kUndetermined = 1e-9;
  const LinearizedNetwork::Factor factor = marginals.linearized().EvaluateFactorAt(id);
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
  const Eigen::MatrixXd product = H * inverse;  // symmetric up to rounding
  prediction.covariance = I + 0.5 * (product + product.transpose());
  prediction.statistic =
      prediction.residual.dot(prediction.covariance.llt().solve(prediction.residual));
  return prediction;
}

Eigen::VectorXd RedundancyNumbers(const Marginals& marginals, FactorId id) {
  if (!marginals.linearized().FindRows(id)) {
    throw InvalidInput("redundancy numbers: factor " + std::to_string(id) + " is not active");
  }
  const LinearizedNetwork::Factor factor = marginals.linearized().EvaluateFactorAt(id);
  const Eigen::ArrayXd share = factor.weight * ModelCovariance(marginals, factor).diagonal();
  return (1.0 - share).cwiseMax(0.0);
}

Eigen::VectorXd RedundancyNumbers(const Marginals& marginals) {
  const LinearizedNetwork& linearized = marginals.linearized();
  const auto& factors = linearized.factors();
  Eigen::VectorXd redundancy(linearized.rows());
  // Blocks that share an active factor are within the pattern, so no triangular solves are needed.
  ParallelFor(static_cast<int>(factors.size()), marginals.threads(), [&](int k) {
    const LinearizedNetwork::FactorRows& rows = factors[static_cast<std::size_t>(k)];
    redundancy.segment(rows.first, rows.count) = RedundancyNumbers(marginals, rows.factor);
  });
  return redundancy;
}

}  // namespace dn
