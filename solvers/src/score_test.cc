#include <dn/error.h>
#include <dn/solvers/robust_loss.h>
#include <dn/solvers/score_test.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <map>
#include <string>
#include <utility>

namespace dn {
namespace {

// Right-hand sides solved together: enough for dense kernels, little memory.
constexpr Eigen::Index kBatchColumns = 48;
// Share of an effect's signature that the unknowns leave, below which nothing is left of it.
constexpr double kAbsorbed = 1e-9;
// The same where effects are conditioned on one another, which costs digits.
constexpr double kAbsorbedJointly = 1e-7;

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

ScoreTest Conclude(const Eigen::VectorXd& s, const Eigen::MatrixXd& A,
                   const Eigen::VectorXd& signature2, double absorbed) {
  ScoreTest test;
  const Eigen::Index q = s.size();
  const Eigen::VectorXd scale =
      signature2.cwiseMax(1e-300).cwiseSqrt().cwiseInverse();  // to a unit signature
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
      Eigen::MatrixXd(scale.asDiagonal() * A * scale.asDiagonal()));
  Eigen::VectorXd inverse = Eigen::VectorXd::Zero(q);
  for (Eigen::Index i = 0; i < q; ++i) {
    if (eigen.eigenvalues()[i] < absorbed) continue;
    inverse[i] = 1.0 / eigen.eigenvalues()[i];
    ++test.dof;
  }
  test.covariance = scale.asDiagonal() * eigen.eigenvectors() * inverse.asDiagonal() *
                    eigen.eigenvectors().transpose() * scale.asDiagonal();
  test.estimate = -test.covariance * s;
  test.statistic = s.dot(test.covariance * s);
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
    tests->push_back(Conclude(sums.s, 0.5 * (A + A.transpose()), sums.LL.diagonal(), kAbsorbed));
  }
}

// The columns of all effects on one factor, side by side; rows of zeros where an effect has none.
std::map<FactorId, std::vector<std::pair<Eigen::Index, const Eigen::MatrixXd*>>> ByFactor(
    const Network& network, const std::vector<EffectModel>& effects,
    const std::vector<Eigen::Index>& first) {
  std::map<FactorId, std::vector<std::pair<Eigen::Index, const Eigen::MatrixXd*>>> by_factor;
  for (std::size_t k = 0; k < effects.size(); ++k) {
    for (const EffectPart& part : effects[k]) {
      CheckPart(network, part, first[k + 1] - first[k]);
      if (network.factor(part.factor).active) {
        by_factor[part.factor].emplace_back(first[k], &part.L);
      }
    }
  }
  return by_factor;
}

Eigen::MatrixXd Submatrix(const Eigen::MatrixXd& A, const std::vector<Eigen::Index>& rows,
                          const std::vector<Eigen::Index>& columns) {
  return A(rows, columns);
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

std::vector<Eigen::Index> JointScore::Components(std::size_t effect) const {
  std::vector<Eigen::Index> components;
  for (Eigen::Index c = first[effect]; c < first[effect + 1]; ++c) components.push_back(c);
  return components;
}

JointScore ScoreEffects(const Network& network, const Marginals& marginals,
                        const std::vector<EffectModel>& effects,
                        const std::vector<BlockId>& watched) {
  JointScore score;
  score.first.push_back(0);
  for (const EffectModel& effect : effects) {
    score.first.push_back(score.first.back() + (effect.empty() ? 0 : effect.front().L.cols()));
  }
  const Eigen::Index q = score.first.back();
  score.s = Eigen::VectorXd::Zero(q);
  score.A = Eigen::MatrixXd::Zero(q, q);
  BlockColumns G;  // J^T L
  for (const auto& [id, parts] : ByFactor(network, effects, score.first)) {
    const FactorRecord& record = network.factor(id);
    Eigen::VectorXd r;
    std::vector<Eigen::MatrixXd> J;
    if (!network.EvaluateFactor(id, &r, &J)) continue;
    Eigen::MatrixXd L = Eigen::MatrixXd::Zero(r.size(), q);
    for (const auto& [column, part] : parts) L.middleCols(column, part->cols()) = *part;
    const double weight = EvaluateLoss(record.loss, r.squaredNorm()).rho_prime;
    score.s += weight * L.transpose() * r;
    score.A += weight * L.transpose() * L;
    for (std::size_t b = 0; b < J.size(); ++b) {
      if (network.block(record.blocks[b]).held) continue;
      Eigen::MatrixXd& g = G[record.blocks[b]];
      if (g.size() == 0) g = Eigen::MatrixXd::Zero(J[b].cols(), q);
      g.noalias() += weight * J[b].transpose() * L;
    }
  }
  score.signature2 = score.A.diagonal();
  const Marginals::Columns Z = marginals.Solve(G);
  for (const auto& [block, g] : G) score.A.noalias() -= g.transpose() * Z.Rows(block);
  score.A = 0.5 * (score.A + Eigen::MatrixXd(score.A.transpose()));
  for (const BlockId block : watched) {
    const Eigen::MatrixXd rows = Z.Rows(block);
    score.shift.conservativeResize(score.shift.rows() + rows.rows(), q);
    score.shift.bottomRows(rows.rows()) = rows;
  }
  return score;
}

ScoreTest TestTogether(const JointScore& score, const std::vector<Eigen::Index>& components) {
  return Conclude(score.s(components), Submatrix(score.A, components, components),
                  score.signature2(components), kAbsorbedJointly);
}

JointScore GivenComponents(const JointScore& score, const std::vector<Eigen::Index>& components) {
  const ScoreTest test = TestTogether(score, components);
  const Eigen::MatrixXd A_jk = score.A(Eigen::all, components);
  const Eigen::MatrixXd gain = test.covariance * A_jk.transpose();  // A_kk^+ A_kj
  JointScore given = score;
  given.s += A_jk * test.estimate;
  given.A -= A_jk * gain;
  if (score.shift.size() > 0) given.shift -= score.shift(Eigen::all, components) * gain;
  return given;
}

}  // namespace dn
