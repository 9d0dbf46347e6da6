#include "unmodelled.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "reduce_words.h"

namespace dn::diagnosis_internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd Symmetric(const MatrixXd& A) { return 0.5 * (A + A.transpose()); }

}  // namespace

UnmodelledUnknowns::UnmodelledUnknowns(const Library& library, const UnmodelledPrior& prior,
                                       const JointScore& score)
    : library_(library), score_(score), estimate_(VectorXd::Zero(score.s.size())) {
  std::vector<double> sigma;
  for (const Hypothesis& hypothesis : library.hypotheses) {
    if (!hypothesis.id || !EffectRow(*hypothesis.id).fixed()) continue;
    const VectorXd sigma_si = prior.Sigma(*hypothesis.id);
    const std::vector<Index> components = hypothesis.Components(score);
    for (std::size_t k = 0; k < components.size(); ++k) {
      const double one = sigma_si[static_cast<Index>(k)];
      if (one == 0.0) continue;
      components_.push_back(components[k]);
      sigma.push_back(one);
    }
  }
  const auto n = static_cast<Index>(sigma.size());
  if (n == 0) return;
  sigma_ = VectorXd::Map(sigma.data(), n);
  const MatrixXd scaled =
      sigma_.asDiagonal() * Symmetric(score.A(components_, components_)) * sigma_.asDiagonal();
  llt_.compute(MatrixXd::Identity(n, n) + scaled);
  inverse_ = llt_.solve(MatrixXd::Identity(n, n));
  estimate_(components_) =
      -sigma_.cwiseProduct(inverse_ * sigma_.cwiseProduct(score.s(components_)));
}

MatrixXd UnmodelledUnknowns::PosteriorRoot() const {
  // With I + sigma A sigma = L L^T, the covariance is (sigma L^-T) (sigma L^-T)^T.
  MatrixXd root = sigma_.asDiagonal();
  llt_.matrixU().solveInPlace<Eigen::OnTheRight>(root);
  return root;
}

MatrixXd UnmodelledUnknowns::AddedCovariance() const {
  const MatrixXd gain = score_.shift(Eigen::all, components_) * PosteriorRoot();
  return gain * gain.transpose();
}

MatrixXd UnmodelledUnknowns::Gain() const {
  MatrixXd gain = MatrixXd::Zero(score_.s.size(), score_.shift.rows());
  const MatrixXd scaled = score_.shift(Eigen::all, components_) * sigma_.asDiagonal();
  gain(components_, Eigen::all) = sigma_.asDiagonal() * (inverse_ * scaled.transpose());
  return gain;
}

MatrixXd UnmodelledUnknowns::PriorCovariance() const {
  const MatrixXd gain = score_.shift(Eigen::all, components_) * sigma_.asDiagonal();
  return gain * gain.transpose();
}

VectorXd UnmodelledUnknowns::EstimateBeside(const VectorXd& others) const {
  if (empty()) return estimate_;
  VectorXd estimate = estimate_;
  estimate(components_) -= sigma_.cwiseProduct(
      inverse_ * sigma_.cwiseProduct(score_.A(components_, Eigen::all) * others));
  return estimate;
}

JointScore UnmodelledUnknowns::Conditioned() const {
  if (empty()) return score_;
  // In units of the prior, with B = (I + A)^-1: A' = B A and s' = B s for the components with a
  // prior. This form does not cancel, whatever the ratio of information to prior.
  const MatrixXd A_all = score_.A(components_, Eigen::all);
  const MatrixXd B = sigma_.cwiseInverse().asDiagonal() * inverse_ * sigma_.asDiagonal();
  const MatrixXd P_A = sigma_.asDiagonal() * inverse_ * sigma_.asDiagonal() * A_all;
  JointScore left = score_;
  left.s += A_all.transpose() * estimate_(components_);
  left.A = Symmetric(score_.A - A_all.transpose() * P_A);
  left.shift -= score_.shift(Eigen::all, components_) * P_A;
  const MatrixXd rows = B * A_all;
  left.s(components_) = B * score_.s(components_);
  left.A(components_, Eigen::all) = rows;
  left.A(Eigen::all, components_) = rows.transpose();
  left.A(components_, components_) = Symmetric(rows(Eigen::all, components_));
  left.shift(Eigen::all, components_) = score_.shift(Eigen::all, components_) * B.transpose();
  const VectorXd signature2 = score_.signature2(components_);
  left.signature2(components_) = signature2.cwiseQuotient(
      VectorXd::Ones(signature2.size()) + signature2.cwiseProduct(sigma_.cwiseAbs2()));
  return left;
}

std::vector<EffectContribution> UnmodelledUnknowns::Contributions(
    const std::vector<Index>& angle_rows, bool corrected) const {
  const MatrixXd posterior = sigma_.asDiagonal() * inverse_ * sigma_.asDiagonal();
  const MatrixXd P = corrected ? posterior : MatrixXd(sigma_.cwiseAbs2().asDiagonal());
  std::vector<std::pair<double, EffectContribution>> all;
  Index first = 0;
  for (const Hypothesis& hypothesis : library_.hypotheses) {
    const std::vector<Index> components = hypothesis.Components(score_);
    std::vector<Index> own;  // indices into components_
    while (first < sigma_.size() && !components.empty() &&
           components_[static_cast<std::size_t>(first)] <= components.back() &&
           components_[static_cast<std::size_t>(first)] >= components.front()) {
      own.push_back(first++);
    }
    if (own.empty()) continue;
    EffectContribution part;
    part.effect = hypothesis.name;
    part.unit = hypothesis.unit;
    part.remedy = ReduceWords(*hypothesis.id);
    const auto n = static_cast<Index>(components.size());
    part.estimate = hypothesis.per_si * estimate_(components);
    part.sigma = part.prior = VectorXd::Zero(n);
    for (const Index k : own) {
      const Index at = components_[static_cast<std::size_t>(k)] - components.front();
      part.sigma[at] = hypothesis.per_si * std::sqrt(posterior(k, k));
      part.prior[at] = hypothesis.per_si * sigma_[k];
    }
    const Eigen::LLT<MatrixXd> inverse(P(own, own));
    Eigen::Vector3d variance = Eigen::Vector3d::Zero();
    for (const Index row : angle_rows) {
      const MatrixXd S = score_.shift.middleRows<3>(row)(Eigen::all, components_);
      const MatrixXd cross = S * P(Eigen::all, own);
      variance += (cross * inverse.solve(cross.transpose())).diagonal();
    }
    part.angle_sigma_rad =
        (variance / static_cast<double>(angle_rows.size())).cwiseMax(0.0).cwiseSqrt();
    const double size = part.angle_sigma_rad.maxCoeff();
    all.emplace_back(size, std::move(part));
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<EffectContribution> sorted;
  for (auto& [size, part] : all) sorted.push_back(std::move(part));
  return sorted;
}

std::optional<double> InPriorSigmas(const UnmodelledPrior& prior, EffectId effect,
                                    const VectorXd& estimate_si, const VectorXd& sigma_si) {
  constexpr double kShown = 3.0;
  if (!EffectRow(effect).fixed()) return std::nullopt;
  const VectorXd prior_si = prior.Sigma(effect);
  if (prior_si.isZero(0.0)) return std::nullopt;
  double shown = 0.0, all = 0.0;
  for (Index k = 0; k < prior_si.size(); ++k) {
    const double value = std::abs(estimate_si[k]);
    const double in_sigmas = value / prior_si[k];  // infinite for a component ruled out
    all = std::max(all, in_sigmas);
    if (value > kShown * sigma_si[k]) shown = std::max(shown, in_sigmas);
  }
  return shown > 0.0 ? shown : all;
}

void SetPriorSigmas(const UnmodelledPrior& prior, const std::vector<HypothesisEvidence>& chosen,
                    std::vector<EffectCheck>* effects) {
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    const HypothesisEvidence& effect = chosen[k];
    (*effects)[k].prior_sigmas = InPriorSigmas(prior, *effect.id, effect.estimate, effect.sigma);
  }
}

}  // namespace dn::diagnosis_internal
