#include <dn/error.h>
#include <dn/log_sum.h>
#include <dn/parallel.h>
#include <dn/size_prior.h>
#include <dn/solvers/score_test.h>
#include <dn/symmetric_eigen.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "linearized_impl.h"
#include "marginals_impl.h"
#include "sparse/sparse.h"

namespace dn {
namespace {

// Number of right-hand sides solved together: enough for dense kernels with little memory.
constexpr Eigen::Index kBatchColumns = 48;
// An effect is inestimable if the unknowns leave less than this fraction of its signature.
constexpr double kAbsorbed = 1e-9;
// The same threshold if effects are conditioned on one another, which costs accuracy.
constexpr double kAbsorbedJointly = 1e-7;

/// Returns the variance of an effect in squares of its typical size.
double PriorVariance(std::size_t g) {
  return SizePrior::kTimesTypical[g] * SizePrior::kTimesTypical[g];
}

void CheckPart(const LinearizedNetwork& linearized, const EffectPart& part, Eigen::Index columns) {
  const int rows = linearized.impl().residual_size(part.factor);
  if (part.L.rows() == rows && part.L.cols() == columns) return;
  throw InvalidInput("score test: an effect of " + std::to_string(columns) +
                     " components on a factor of " + std::to_string(rows) + " residuals has " +
                     std::to_string(part.L.rows()) + " x " + std::to_string(part.L.cols()) +
                     " derivatives");
}

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// A run of consecutive columns among those of all effects.
struct ColumnRun {
  Eigen::Index first = 0;  ///< index among all columns
  Eigen::Index at = 0;     ///< index among the columns that are not zero on the factor
  Eigen::Index count = 0;
};

/// The columns of several effects that are not zero on one factor.
struct Touched {
  std::vector<Eigen::Index> columns;
  std::vector<ColumnRun> runs;
  RowMajor L;
};

/// Calls use(position of a block, its columns of the factor's Jacobian) for each block of a factor.
template <class Use>
void ForJacobians(const LinearizedNetwork& linearized, FactorId factor, const Use& use) {
  const LinearizedNetwork::Impl& network = linearized.impl();
  const Linearization::Edge& edge =
      network.linearization.edges()[static_cast<std::size_t>(network.factor(factor).edge)];
  const auto J = network.linearization.jacobian(edge);
  int column = 0;
  for (int b = 0; b < edge.num_blocks; ++b) {
    const int position = network.linearization.positions(edge)[b];
    const int size = network.layout.block_size(position);
    use(position, J.middleCols(column, size));
    column += size;
  }
}

ScoreTest Conclude(const Eigen::VectorXd& s, const Eigen::MatrixXd& A,
                   const Eigen::VectorXd& signature2, double absorbed) {
  ScoreTest test;
  const Eigen::Index q = s.size();
  const Eigen::VectorXd scale =
      signature2.cwiseMax(1e-300).cwiseSqrt().cwiseInverse();  // scales to a unit signature
  const SymmetricEigen eigen(scale.asDiagonal() * A * scale.asDiagonal());
  Eigen::VectorXd inverse = Eigen::VectorXd::Zero(q);
  for (Eigen::Index i = 0; i < q; ++i) {
    if (eigen.values[i] < absorbed) continue;
    inverse[i] = 1.0 / eigen.values[i];
    ++test.dof;
  }
  test.covariance = scale.asDiagonal() * eigen.vectors * inverse.asDiagonal() *
                    eigen.vectors.transpose() * scale.asDiagonal();
  test.estimate = -test.covariance * s;
  test.statistic = s.dot(test.covariance * s);
  return test;
}

/// First column and derivatives of each effect on a factor.
using Parts = std::vector<std::pair<Eigen::Index, const Eigen::MatrixXd*>>;

struct FactorParts {
  FactorId factor = -1;
  LinearizedNetwork::FactorRows rows;
  Parts parts;
};

/// Groups the parts of all effects by active factor, in the order of the factors.
std::vector<FactorParts> ByFactor(const LinearizedNetwork& linearized,
                                  const std::vector<const EffectModel*>& effects,
                                  const std::vector<Eigen::Index>& first) {
  std::vector<FactorParts> by_factor;
  std::vector<std::size_t> at;  // index in by_factor plus 1 for each factor; 0: not present yet
  for (std::size_t k = 0; k < effects.size(); ++k) {
    for (const EffectPart& part : *effects[k]) {
      CheckPart(linearized, part, first[k + 1] - first[k]);
      const std::size_t id = AsSize(part.factor);
      if (id >= at.size()) at.resize(2 * id + 1, 0);
      if (at[id] == 0) {
        const auto rows = linearized.FindRows(part.factor);
        if (!rows) continue;
        by_factor.push_back({part.factor, *rows, {}});
        at[id] = by_factor.size();
      }
      by_factor[at[id] - 1].parts.emplace_back(first[k], &part.L);
    }
  }
  std::sort(by_factor.begin(), by_factor.end(),
            [](const FactorParts& a, const FactorParts& b) { return a.factor < b.factor; });
  return by_factor;
}

std::vector<ColumnRun> Runs(const std::vector<Eigen::Index>& columns) {
  std::vector<ColumnRun> runs;
  for (std::size_t k = 0; k < columns.size(); ++k) {
    if (runs.empty() || runs.back().first + runs.back().count != columns[k]) {
      runs.push_back({columns[k], static_cast<Eigen::Index>(k), 0});
    }
    ++runs.back().count;
  }
  return runs;
}

/// Returns the parts of the runs within the columns [begin, past).
std::vector<ColumnRun> Within(const std::vector<ColumnRun>& runs, Eigen::Index begin,
                              Eigen::Index past) {
  std::vector<ColumnRun> within;
  for (const ColumnRun& run : runs) {
    const Eigen::Index first = std::max(run.first, begin);
    const Eigen::Index count = std::min(run.first + run.count, past) - first;
    if (count > 0) within.push_back({first, run.at + first - run.first, count});
  }
  return within;
}

Touched ColumnsThatTouch(const LinearizedNetwork& linearized, const Parts& parts,
                         const LinearizedNetwork::FactorRows& rows) {
  Touched touched;
  std::vector<std::pair<const Eigen::MatrixXd*, Eigen::Index>> from;
  for (const auto& [first, part] : parts) {
    for (Eigen::Index c = 0; c < part->cols(); ++c) {
      if (part->col(c).isZero(0.0)) continue;
      touched.columns.push_back(first + c);
      from.emplace_back(part, c);
    }
  }
  touched.L.resize(rows.count, static_cast<Eigen::Index>(from.size()));
  for (std::size_t k = 0; k < from.size(); ++k) {
    touched.L.col(static_cast<Eigen::Index>(k)) = from[k].first->col(from[k].second);
  }
  touched.L = ToRowScaling(linearized, rows, touched.L);
  touched.runs = Runs(touched.columns);
  return touched;
}

/// Computes V N^-1 V^T for all effects, V = (J^T L)^T, and for unit changes of the watched blocks.
/// With N = R R^T and W = V R^-T it equals W W^T.
class Projections {
 public:
  /// Allocates W for `columns` columns of effects and `num_watched` coordinates of watched blocks.
  Projections(const Marginals::Impl& marginals, Eigen::Index columns, Eigen::Index num_watched)
      : marginals_(marginals),
        columns_(columns),
        zeros_(sparse::NewZeros(AsSize(columns + num_watched) * AsSize(layout().size()))),
        W_(zeros_.get(), columns + num_watched, layout().size()) {}

  /// Adds a factor to the effect columns [begin, past). Disjoint ranges may run in parallel.
  void Add(FactorId factor, const Touched& touched, Eigen::Index begin, Eigen::Index past) {
    const std::vector<ColumnRun> runs = Within(touched.runs, begin, past);
    if (runs.empty()) return;
    ForJacobians(marginals_.linearized, factor, [&](int position, const auto& J) {
      for (Eigen::Index i = 0; i < J.cols(); ++i) {
        const int unknown = marginals_.Offset(position) + static_cast<int>(i);
        auto of_unknown = W_.col(Row(unknown));
        for (Eigen::Index r = 0; r < J.rows(); ++r) {
          const double weight = marginals_.scale[unknown] * J(r, i);
          for (const ColumnRun& run : runs) {
            of_unknown.segment(run.first, run.count) +=
                weight * touched.L.row(r).segment(run.at, run.count).transpose();
          }
        }
      }
    });
  }

  void Watch(const std::vector<BlockId>& blocks) {
    Eigen::Index row = columns_;
    for (const BlockId block : blocks) {
      const Eigen::Index first = marginals_.linearized.FirstColumn(block);
      const int size = marginals_.block(block).kind.tangent_size;
      for (int i = 0; i < size && first >= 0; ++i) {
        const int unknown = static_cast<int>(first) + i;
        W_(row + i, Row(unknown)) = marginals_.scale[unknown];
      }
      row += size;
    }
  }

  Eigen::Index columns() const { return columns_; }

  /// Returns the lower triangle of V N^-1 V^T: effects first, then the watched blocks.
  Eigen::MatrixXd Products() {
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(W_.rows(), W_.rows());
    if (W_.size() == 0) return sum;
    marginals_.cholesky->SolveForward(marginals_.threads, W_);
    std::vector<Eigen::MatrixXd> shares(kShares);
    ParallelFor(kShares, marginals_.threads, [&](int k) {
      const sparse::SerialBlas serial;
      const Eigen::Index first = W_.cols() * k / kShares, past = W_.cols() * (k + 1) / kShares;
      shares[AsSize(k)] = OwnProduct(first, past);
    });
    for (const Eigen::MatrixXd& share : shares) sum += share;
    return sum;
  }

 private:
  // Fixed, so that the result does not depend on the number of threads.
  static constexpr int kShares = 8;

  /// Returns the product over the unknowns [first, past) in the order of the factorisation.
  Eigen::MatrixXd OwnProduct(Eigen::Index first, Eigen::Index past) const {
    Eigen::MatrixXd product = Eigen::MatrixXd::Zero(W_.rows(), W_.rows());
    const auto n = static_cast<int>(W_.rows()), k = static_cast<int>(past - first);
    if (k > 0) {
      sparse::Square(n, k, W_.col(first).data(), product.data());
    }
    return product;
  }

  const UnknownLayout& layout() const { return marginals_.layout(); }
  Eigen::Index Row(int unknown) const {
    return marginals_.cholesky->permuted_index()[AsSize(unknown)];
  }

  const Marginals::Impl& marginals_;
  Eigen::Index columns_;
  std::unique_ptr<double[], sparse::FreeZeros> zeros_;
  // One column for each unknown, in the order of the factorisation.
  Eigen::Map<Eigen::MatrixXd> W_;
};

/// Accumulates L^T r and L^T L. Factors with the same columns are stacked and multiplied together.
class ScoreSum {
 public:
  ScoreSum(const LinearizedNetwork& linearized, JointScore* score)
      : linearized_(linearized), score_(*score) {}
  ~ScoreSum() { AddStack(); }
  ScoreSum(const ScoreSum&) = delete;
  ScoreSum& operator=(const ScoreSum&) = delete;

  void Add(const LinearizedNetwork::FactorRows& rows, const Touched& touched) {
    if (touched.columns.empty()) return;
    const auto count = touched.L.rows();
    if (touched.columns != columns_ || filled_ + count > L_.rows()) {
      AddStack();
      columns_ = touched.columns;
      L_.resize(std::max(kStackedRows, count), touched.L.cols());
      r_.resize(L_.rows());
    }
    L_.middleRows(filled_, count) = touched.L;
    r_.segment(filled_, count) = linearized_.residual().segment(rows.first, count);
    filled_ += count;
  }

 private:
  static constexpr Eigen::Index kStackedRows = 192;

  void AddStack() {
    if (filled_ == 0) return;
    const auto L = L_.topRows(filled_);
    score_.s(columns_) += L.transpose() * r_.head(filled_);
    score_.A(columns_, columns_) += L.transpose() * L;
    filled_ = 0;
  }

  const LinearizedNetwork& linearized_;
  JointScore& score_;
  std::vector<Eigen::Index> columns_;
  Eigen::MatrixXd L_;
  Eigen::VectorXd r_;
  Eigen::Index filled_ = 0;
};

// One task sums the scores, and each of the others sums a fixed range of columns of J^T L. The
// result does not depend on the number of threads.
void SumScores(const LinearizedNetwork& linearized, const std::vector<FactorParts>& factors,
               int threads, Projections* G, JointScore* score) {
  constexpr std::size_t kAtOnce = 1024;
  constexpr int kColumnShares = 3;
  ScoreSum sum(linearized, score);
  std::vector<Touched> touched(std::min(kAtOnce, factors.size()));
  for (std::size_t first = 0; first < factors.size(); first += kAtOnce) {
    const std::span<const FactorParts> some =
        std::span(factors).subspan(first, std::min(kAtOnce, factors.size() - first));
    ParallelFor(static_cast<int>(some.size()), threads, [&](int at) {
      const FactorParts& of = some[AsSize(at)];
      touched[AsSize(at)] = ColumnsThatTouch(linearized, of.parts, of.rows);
    });
    ParallelFor(1 + kColumnShares, threads, [&](int share) {
      for (std::size_t k = 0; k < some.size(); ++k) {
        if (share == 0) {
          sum.Add(some[k].rows, touched[k]);
        } else {
          G->Add(some[k].factor, touched[k], G->columns() * (share - 1) / kColumnShares,
                 G->columns() * share / kColumnShares);
        }
      }
    });
  }
}

Eigen::MatrixXd Submatrix(const Eigen::MatrixXd& A, const std::vector<Eigen::Index>& rows,
                          const std::vector<Eigen::Index>& columns) {
  return A(rows, columns);
}

}  // namespace

std::vector<ScoreTest> TestEffects(const Marginals& marginals,
                                   const std::vector<EffectModel>& effects) {
  std::vector<ScoreTest> tests;
  tests.reserve(effects.size());
  std::vector<const EffectModel*> batch;
  Eigen::Index columns = 0;
  const auto flush = [&] {
    const JointScore score = ScoreEffects(marginals, batch, {});
    for (std::size_t k = 0; k < batch.size(); ++k) {
      const Eigen::Index first = score.first[k], q = score.first[k + 1] - first;
      tests.push_back(Conclude(score.s.segment(first, q), score.A.block(first, first, q, q),
                               score.signature2.segment(first, q), kAbsorbed));
    }
    batch.clear();
    columns = 0;
  };
  for (const EffectModel& effect : effects) {
    batch.push_back(&effect);
    columns += effect.empty() ? 0 : effect.front().L.cols();
    if (columns >= kBatchColumns) flush();
  }
  if (!batch.empty()) flush();
  return tests;
}

std::vector<Eigen::Index> JointScore::Components(std::size_t effect) const {
  std::vector<Eigen::Index> components;
  for (Eigen::Index c = first[effect]; c < first[effect + 1]; ++c) components.push_back(c);
  return components;
}

JointScore ScoreEffects(const Marginals& marginals, const std::vector<EffectModel>& effects,
                        const std::vector<BlockId>& watched) {
  std::vector<const EffectModel*> in_place;
  for (const EffectModel& effect : effects) in_place.push_back(&effect);
  return ScoreEffects(marginals, in_place, watched);
}

JointScore ScoreEffects(const Marginals& marginals, const std::vector<const EffectModel*>& effects,
                        const std::vector<BlockId>& watched) {
  const LinearizedNetwork& linearized = marginals.linearized();
  JointScore score;
  score.first.push_back(0);
  for (const EffectModel* effect : effects) {
    score.first.push_back(score.first.back() + (effect->empty() ? 0 : effect->front().L.cols()));
  }
  const Eigen::Index q = score.first.back();
  score.s = Eigen::VectorXd::Zero(q);
  score.A = Eigen::MatrixXd::Zero(q, q);
  const std::vector<FactorParts> factors = ByFactor(linearized, effects, score.first);
  Eigen::Index num_watched = 0;
  for (const BlockId block : watched)
    num_watched += linearized.impl().block(block).kind.tangent_size;
  Projections G(marginals.impl(), q, num_watched);
  G.Watch(watched);
  SumScores(linearized, factors, marginals.impl().threads, &G, &score);
  score.signature2 = score.A.diagonal();
  const Eigen::MatrixXd projected = G.Products();
  score.A -= projected.topLeftCorner(q, q);
  score.A = Eigen::MatrixXd(score.A.selfadjointView<Eigen::Lower>());
  score.shift = projected.bottomLeftCorner(num_watched, q);
  return score;
}

ScoreTest TestScore(const Eigen::VectorXd& s, const Eigen::MatrixXd& A,
                    const Eigen::VectorXd& signature2) {
  return Conclude(s, A, signature2, kAbsorbedJointly);
}

ScoreTest TestJointly(const JointScore& score, const std::vector<Eigen::Index>& components) {
  return TestScore(score.s(components), Submatrix(score.A, components, components),
                   score.signature2(components));
}

ScoreTest TestCombinations(const JointScore& score, const Eigen::MatrixXd& T) {
  return TestScore(T.transpose() * score.s, T.transpose() * score.A * T,
                   T.cwiseAbs2().transpose() * score.signature2);
}

JointScore ConditionOn(const JointScore& score, const Eigen::MatrixXd& T) {
  if (T.cols() == 0) return score;
  const ScoreTest test = TestCombinations(score, T);
  const Eigen::MatrixXd AT = score.A * T;
  JointScore given = score;
  given.s += AT * test.estimate;
  given.A -= AT * test.covariance * AT.transpose();
  given.shift -= score.shift * T * test.covariance * AT.transpose();
  return given;
}

SizeAveragedEvidence::SizeAveragedEvidence(const Eigen::MatrixXd& A,
                                           const Eigen::VectorXd& typical) {
  const SymmetricEigen eigen(typical.asDiagonal() * A * typical.asDiagonal());
  W_ = typical.asDiagonal() * eigen.vectors;
  d_ = eigen.values.cwiseMax(0.0);
  for (std::size_t g = 0; g < log_growth_.size(); ++g) log_growth_[g] = LogGrowth(PriorVariance(g));
}

double SizeAveragedEvidence::LogGrowth(double variance) const {
  return (1.0 + variance * d_.array()).log().sum();
}

double SizeAveragedEvidence::Explained(const Eigen::VectorXd& c, double variance) const {
  return variance * (c.array().square() / (1.0 + variance * d_.array())).sum();
}

double SizeAveragedEvidence::LogEvidence(const Eigen::VectorXd& s, double variance) const {
  return 0.5 * (Explained(W_.transpose() * s, variance) - LogGrowth(variance));
}

double SizeAveragedEvidence::LogEvidence(const Eigen::VectorXd& s) const {
  const Eigen::VectorXd c = W_.transpose() * s;
  LogSum sum;
  for (std::size_t g = 0; g < log_growth_.size(); ++g) {
    sum.Add(std::log(SizePrior::kProbability[g]) +
            0.5 * (Explained(c, PriorVariance(g)) - log_growth_[g]));
  }
  return sum.Value();
}

LinearMoments SizeAveragedEvidence::Moments(const Eigen::VectorXd& s,
                                            const Eigen::MatrixXd& F) const {
  const Eigen::VectorXd c = W_.transpose() * s;
  const Eigen::MatrixXd FW = F * W_;
  const double log_evidence = LogEvidence(s);
  // They are normalised, because huge evidences have rounding errors.
  Eigen::Matrix<double, SizePrior::kSizes, 1> weights;
  for (std::size_t g = 0; g < SizePrior::kSizes; ++g) {
    weights[static_cast<Eigen::Index>(g)] =
        SizePrior::kProbability[g] * std::exp(LogEvidence(s, PriorVariance(g)) - log_evidence);
  }
  weights /= weights.sum();
  std::array<Eigen::VectorXd, SizePrior::kSizes> means;
  LinearMoments out{Eigen::VectorXd::Zero(F.rows()), Eigen::MatrixXd::Zero(F.rows(), F.rows())};
  for (std::size_t g = 0; g < means.size(); ++g) {
    const double v = PriorVariance(g), weight = weights[static_cast<Eigen::Index>(g)];
    const Eigen::VectorXd gain = v / (1.0 + v * d_.array());
    means[g] = -FW * gain.cwiseProduct(c);
    out.mean += weight * means[g];
    out.covariance += weight * (FW * gain.asDiagonal() * FW.transpose());
  }
  // The spread is summed about the mean, which may be large relative to it.
  for (std::size_t g = 0; g < means.size(); ++g) {
    const Eigen::VectorXd off = means[g] - out.mean;
    out.covariance += weights[static_cast<Eigen::Index>(g)] * (off * off.transpose());
  }
  return out;
}

Eigen::MatrixXd TransposeTimes(const LinearizedNetwork& linearized, const EffectModel& effect,
                               const Eigen::MatrixXd& R) {
  const Eigen::Index q = effect.empty() ? 0 : effect.front().L.cols();
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(q, R.cols());
  for (const EffectPart& part : effect) {
    CheckPart(linearized, part, q);
    const auto rows = linearized.FindRows(part.factor);
    if (!rows) continue;
    product.noalias() +=
        std::sqrt(rows->weight) * part.L.transpose() * R.middleRows(rows->first, rows->count);
  }
  return product;
}

}  // namespace dn
