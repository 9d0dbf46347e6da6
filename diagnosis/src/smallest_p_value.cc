#include "smallest_p_value.h"

#include <dn/distributions.h>
#include <dn/solvers/fit_check.h>
#include <dn/symmetric_eigen.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "evidence.h"

namespace dn::diagnosis_internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

constexpr unsigned kSeed = 20250210;
// The smallest p-value of a replicate whose logarithm is used.
constexpr double kSmallestP = 1e-300;

/// Returns the moments of samples with one of them left out.
FormMoments Without(Index left_out, const RowVectorXd& samples) {
  std::vector<double> others;
  for (Index k = 0; k < samples.size(); ++k) {
    if (k != left_out) others.push_back(samples[k]);
  }
  return SampleMoments(others);
}

/// Returns draws of the scores, one per column.
MatrixXd DrawScores(const JointScore& score, int draws) {
  const VectorXd unit = score.signature2.cwiseMax(kSmallestP).cwiseSqrt();
  const VectorXd inverse = unit.cwiseInverse();
  const SymmetricEigen eigen(inverse.asDiagonal() * score.A * inverse.asDiagonal());
  std::mt19937_64 generator(kSeed);
  std::normal_distribution<double> normal;
  MatrixXd Z(score.s.size(), draws);
  for (double& z : Z.reshaped()) z = normal(generator);
  return unit.asDiagonal() * eigen.vectors *
         (eigen.values.cwiseMax(0.0).cwiseSqrt().asDiagonal() * Z);
}

}  // namespace

double EffectiveTests(const VectorXd& smallest) {
  // The density m (1 - p)^(m - 1) makes -ln(1 - p) exponential with the mean 1 / m.
  const VectorXd exponential =
      smallest.unaryExpr([](double p) { return -std::log1p(-std::min(p, 1.0 - 1e-12)); });
  const double sum = std::max(exponential.sum(), kSmallestP);
  return std::max(1.0, (static_cast<double>(smallest.size()) - 1.0) / sum);
}

double FamilyPValue(double smallest, double effective_tests) {
  if (smallest >= 1.0) return 1.0;
  return -std::expm1(effective_tests * std::log1p(-smallest));
}

VectorXd SmallestFormPValues(const std::vector<FormMoments>& moments, const MatrixXd& energies,
                             const VectorXd& redundancy) {
  VectorXd smallest = VectorXd::Ones(energies.cols());
  for (std::size_t k = 0; k < moments.size(); ++k) {
    const auto form = static_cast<Index>(k);
    for (Index sample = 0; sample < energies.cols(); ++sample) {
      const FormMoments expected =
          moments[k].samples == 0 ? moments[k] : Without(sample, energies.row(form));
      const double energy = energies(form, sample);
      const double p = form < redundancy.size() ? ChannelPValue(redundancy[form], expected, energy)
                                                : expected.UpperTail(energy);
      smallest[sample] = std::min(smallest[sample], p);
    }
  }
  return smallest;
}

double SmallestEffectPValue(const Library& library, const JointScore& score) {
  double smallest = 1.0;
  for (const Hypothesis& hypothesis : library.hypotheses) {
    if (!hypothesis.id) continue;
    const ScoreTest test = TestHypothesis(hypothesis, score);
    if (test.dof > 0) smallest = std::min(smallest, ChiSquareTail(test.statistic, test.dof));
  }
  return smallest;
}

VectorXd SmallestScorePValues(const Library& library, const JointScore& score, int draws) {
  const MatrixXd s = DrawScores(score, draws);
  std::map<int, RowVectorXd> largest;  // statistics by their degrees of freedom
  for (const Hypothesis& hypothesis : library.hypotheses) {
    if (library.blocks[hypothesis.block].empty()) continue;
    const ScoreTest test = TestHypothesis(hypothesis, score);
    if (test.dof == 0) continue;
    const MatrixXd own = s(hypothesis.Components(score), Eigen::all);
    const RowVectorXd statistic = own.cwiseProduct(test.covariance * own).colwise().sum();
    RowVectorXd& most = largest.try_emplace(test.dof, RowVectorXd::Zero(draws)).first->second;
    most = most.cwiseMax(statistic);
  }
  VectorXd smallest = VectorXd::Ones(draws);
  for (const auto& [dof, statistic] : largest) {
    for (Index k = 0; k < draws; ++k) {
      smallest[k] = std::min(smallest[k], ChiSquareTail(statistic[k], dof));
    }
  }
  return smallest;
}

}  // namespace dn::diagnosis_internal
