#include <dn/error.h>
#include <dn/solvers/robust_loss.h>
#include <dn/solvers/score_test.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <string>

namespace dn {
namespace {

// Right-hand sides solved together: enough for dense kernels, little memory.
constexpr Eigen::Index kBatchColumns = 48;
// Share of an effect's signature that the unknowns leave, below which nothing is left of it.
constexpr double kAbsorbed = 1e-9;

/// The sums of one effect over its factors.
struct Sums {
  Eigen::VectorXd s;   // L^T r
  Eigen::MatrixXd LL;  // L^T L
  BlockColumns g;      // J^T L
};

void CheckPart(const Network& network, const EffectPart& part, Eigen::Index columns) {
  const int rows = network.factor(part.factor).factor->residual_size();
  if (part.L.rows() == rows && part.L.cols() == columns) return;
  throw InvalidInput("score test: an effect of " + std::to_string(columns) +
                     " components on a factor of " + std::to_string(rows) + " residuals has " +
                     std::to_string(part.L.rows()) + " x " + std::to_string(part.L.cols()) +
                     " derivatives");
}

Sums Sum(const Network& network, const EffectModel& effect) {
  const Eigen::Index q = effect.empty() ? 0 : effect.front().L.cols();
  Sums sums{Eigen::VectorXd::Zero(q), Eigen::MatrixXd::Zero(q, q), {}};
  for (const EffectPart& part : effect) {
    CheckPart(network, part, q);
    const FactorRecord& record = network.factor(part.factor);
    Eigen::VectorXd r;
    std::vector<Eigen::MatrixXd> J;
    if (!record.active || !network.EvaluateFactor(part.factor, &r, &J)) continue;
    const double weight = EvaluateLoss(record.loss, r.squaredNorm()).rho_prime;
    sums.s += weight * part.L.transpose() * r;
    sums.LL += weight * part.L.transpose() * part.L;
    for (std::size_t b = 0; b < J.size(); ++b) {
      if (network.block(record.blocks[b]).held) continue;
      Eigen::MatrixXd& g = sums.g[record.blocks[b]];
      if (g.size() == 0) g = Eigen::MatrixXd::Zero(J[b].cols(), q);
      g += weight * J[b].transpose() * part.L;
    }
  }
  return sums;
}

ScoreTest Conclude(const Sums& sums, const Eigen::MatrixXd& A) {
  ScoreTest test;
  const Eigen::Index q = sums.s.size();
  const Eigen::VectorXd scale =
      sums.LL.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();  // to a unit signature
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
      Eigen::MatrixXd(scale.asDiagonal() * A * scale.asDiagonal()));
  Eigen::VectorXd inverse = Eigen::VectorXd::Zero(q);
  for (Eigen::Index i = 0; i < q; ++i) {
    if (eigen.eigenvalues()[i] < kAbsorbed) continue;
    inverse[i] = 1.0 / eigen.eigenvalues()[i];
    ++test.dof;
  }
  test.covariance = scale.asDiagonal() * eigen.eigenvectors() * inverse.asDiagonal() *
                    eigen.eigenvectors().transpose() * scale.asDiagonal();
  test.estimate = -test.covariance * sums.s;
  test.statistic = sums.s.dot(test.covariance * sums.s);
  return test;
}

void TestBatch(const Marginals& marginals, const std::vector<Sums>& batch, Eigen::Index columns,
               std::vector<ScoreTest>* tests) {
  BlockColumns rhs;
  Eigen::Index c = 0;
  for (const Sums& sums : batch) {
    for (const auto& [block, g] : sums.g) {
      Eigen::MatrixXd& B = rhs[block];
      if (B.size() == 0) B = Eigen::MatrixXd::Zero(g.rows(), columns);
      B.middleCols(c, g.cols()) = g;
    }
    c += sums.s.size();
  }
  const Marginals::Columns Z = marginals.Solve(rhs);
  c = 0;
  for (const Sums& sums : batch) {
    Eigen::MatrixXd A = sums.LL;
    for (const auto& [block, g] : sums.g) {
      A -= g.transpose() * Z.Rows(block).middleCols(c, g.cols());
    }
    c += sums.s.size();
    tests->push_back(Conclude(sums, 0.5 * (A + A.transpose())));
  }
}

}  // namespace

std::vector<ScoreTest> TestEffects(const Network& network, const Marginals& marginals,
                                   const std::vector<EffectModel>& effects) {
  std::vector<ScoreTest> tests;
  tests.reserve(effects.size());
  std::vector<Sums> batch;
  Eigen::Index columns = 0;
  const auto flush = [&] {
    if (!batch.empty()) TestBatch(marginals, batch, columns, &tests);
    batch.clear();
    columns = 0;
  };
  for (const EffectModel& effect : effects) {
    batch.push_back(Sum(network, effect));
    columns += batch.back().s.size();
    if (columns >= kBatchColumns) flush();
  }
  flush();
  return tests;
}

}  // namespace dn
