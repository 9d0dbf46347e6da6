#include "unmodelled.h"

#include <dn/effects/gnss_process_prior.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "reduce_words.h"
#include "semidefinite_root.h"

namespace dn::diagnosis_internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Relative rounding of the covariance of a process.
constexpr double kRounding = 1e-12;

MatrixXd Symmetric(const MatrixXd& A) { return 0.5 * (A + A.transpose()); }

/// Returns the factorisation of I + sigma A sigma.
Eigen::LLT<MatrixXd> FactorInPriorUnits(const MatrixXd& A, const VectorXd& sigma) {
  MatrixXd scaled = sigma.asDiagonal() * Symmetric(A) * sigma.asDiagonal();
  scaled.diagonal().array() += 1.0;
  return Eigen::LLT<MatrixXd>(scaled);
}

/// Returns the scores of all components if some of them are unknowns with the prior `sigma`.
/// `inverse` is that of I + sigma A sigma.
JointScore ConditionOnPrior(const JointScore& score, const std::vector<Index>& components,
                            const VectorXd& sigma, const MatrixXd& inverse) {
  // In units of the prior, B = (I + A)^-1. Components with a prior then have A' = B A and s' = B s.
  // This form does not cancel, whatever the ratio of information to prior.
  const MatrixXd A_all = score.A(components, Eigen::all);
  const MatrixXd B = sigma.cwiseInverse().asDiagonal() * inverse * sigma.asDiagonal();
  const MatrixXd P = sigma.asDiagonal() * inverse * sigma.asDiagonal();
  const MatrixXd P_A = P * A_all;
  JointScore left = score;
  left.s -= P_A.transpose() * score.s(components);
  left.A = Symmetric(score.A - A_all.transpose() * P_A);
  left.shift -= score.shift(Eigen::all, components) * P_A;
  const MatrixXd rows = B * A_all;
  left.s(components) = B * score.s(components);
  left.A(components, Eigen::all) = rows;
  left.A(Eigen::all, components) = rows.transpose();
  left.A(components, components) = Symmetric(rows(Eigen::all, components));
  left.shift(Eigen::all, components) = score.shift(Eigen::all, components) * B.transpose();
  const VectorXd signature2 = score.signature2(components);
  left.signature2(components) = signature2.cwiseQuotient(
      VectorXd::Ones(signature2.size()) + signature2.cwiseProduct(sigma.cwiseAbs2()));
  return left;
}

}  // namespace

UnmodelledUnknowns::UnmodelledUnknowns(const Library& library, const UnmodelledPrior& prior,
                                       const JointScore& score,
                                       const std::optional<GnssProcessBasis>& process,
                                       SizeSource source)
    : library_(library), score_(score), estimate_(VectorXd::Zero(score.s.size())) {
  std::vector<double> sigma;
  for (const Hypothesis& hypothesis : library.hypotheses) {
    // A hypothesis of cells is one of many windows or starts; none of them has a prior.
    if (!hypothesis.id || hypothesis.cells || !EffectRow(*hypothesis.id).fixed()) continue;
    const VectorXd sigma_si = prior.Sigma(*hypothesis.id);
    const std::vector<Index> components = hypothesis.Components(score);
    for (std::size_t k = 0; k < components.size(); ++k) {
      const double one = sigma_si[static_cast<Index>(k)];
      if (one == 0.0) continue;
      fixed_.push_back(components[k]);
      effect_.push_back(*hypothesis.id);
      within_.push_back(static_cast<Index>(k));
      sigma.push_back(one);
    }
  }
  components_ = fixed_;
  const auto n = static_cast<Index>(sigma.size());
  sigma_ = VectorXd::Map(sigma.data(), n);
  if (n > 0) {
    llt_ = FactorInPriorUnits(score.A(fixed_, fixed_), sigma_);
    inverse_ = llt_.solve(MatrixXd::Identity(n, n));
    covariance_ = sigma_.asDiagonal() * inverse_ * sigma_.asDiagonal();
    estimate_(fixed_) = -sigma_.cwiseProduct(inverse_ * sigma_.cwiseProduct(score.s(fixed_)));
  }
  if (process) AddProcess(*process, source);
}

void UnmodelledUnknowns::AddProcess(const GnssProcessBasis& process, SizeSource source) {
  coefficients_ = score_.Components(process.block);
  const auto n = static_cast<Index>(fixed_.size()), m = static_cast<Index>(coefficients_.size());
  const MatrixXd cross = score_.A(fixed_, coefficients_);
  response_ = n > 0 ? MatrixXd(-covariance_ * cross) : MatrixXd(0, m);
  const VectorXd s = score_.s(coefficients_) + cross.transpose() * estimate_(fixed_);
  const MatrixXd A =
      Symmetric(score_.A(coefficients_, coefficients_) + cross.transpose() * response_);
  process_ = MixProcess(s, A, process.Sizes(), process.Shapes(), source);
  estimate_(coefficients_) = process_->mean;
  estimate_(fixed_) += response_ * process_->mean;
  const MatrixXd fixed = n > 0 ? covariance_ : MatrixXd(0, 0);
  const MatrixXd moved = response_ * process_->covariance;
  covariance_.resize(n + m, n + m);
  covariance_ << fixed + moved * response_.transpose(), moved, moved.transpose(),
      process_->covariance;
  components_.insert(components_.end(), coefficients_.begin(), coefficients_.end());
}

MatrixXd UnmodelledUnknowns::PosteriorRoot() const {
  // With I + sigma A sigma = L L^T, the covariance is (sigma L^-T) (sigma L^-T)^T.
  MatrixXd fixed = sigma_.asDiagonal();
  if (!fixed_.empty()) llt_.matrixU().solveInPlace<Eigen::OnTheRight>(fixed);
  if (!process_) return fixed;
  const MatrixXd& C = process_->covariance;
  const MatrixXd process = SemidefiniteRoot(C, kRounding * C.diagonal());
  const auto n = fixed.rows(), m = process.rows();
  MatrixXd root(n + m, n + m);
  root << fixed, response_ * process, MatrixXd::Zero(m, n), process;
  return root;
}

MatrixXd UnmodelledUnknowns::AddedCovariance() const {
  const MatrixXd gain = score_.shift(Eigen::all, components_) * PosteriorRoot();
  return gain * gain.transpose();
}

MatrixXd UnmodelledUnknowns::Gain() const {
  MatrixXd gain = MatrixXd::Zero(score_.s.size(), score_.shift.rows());
  gain(components_, Eigen::all) = covariance_ * score_.shift(Eigen::all, components_).transpose();
  return gain;
}

MatrixXd UnmodelledUnknowns::PriorCovariance() const {
  const MatrixXd gain = score_.shift(Eigen::all, fixed_) * sigma_.asDiagonal();
  return gain * gain.transpose();
}

EffectPosterior UnmodelledUnknowns::Posterior() const {
  const MatrixXd root = PosteriorRoot();
  const MatrixXd fixed = root.topRows(static_cast<Index>(fixed_.size()));
  const MatrixXd shift = score_.shift(Eigen::all, components_) * root;
  EffectPosterior posterior{effect_, within_, sigma_, estimate_(fixed_), {}, {}, {}, Correction()};
  posterior.covariance = fixed * fixed.transpose();
  posterior.added = shift * shift.transpose();
  posterior.cross = -shift * fixed.transpose();
  return posterior;
}

VectorXd UnmodelledUnknowns::EstimateBeside(const VectorXd& others) const {
  VectorXd estimate = estimate_;
  if (!empty()) {
    estimate(components_) -= covariance_ * (score_.A(components_, Eigen::all) * others);
  }
  return estimate;
}

MatrixXd UnmodelledUnknowns::Follow(const MatrixXd& X) const {
  MatrixXd all = X;
  if (!empty()) {
    all(components_, Eigen::all) -= covariance_ * (score_.A(components_, Eigen::all) * X);
  }
  return all;
}

JointScore UnmodelledUnknowns::Conditioned() const {
  if (empty()) return score_;
  JointScore left = fixed_.empty() ? score_ : ConditionOnPrior(score_, fixed_, sigma_, inverse_);
  if (!process_) return left;
  const Eigen::LLT<MatrixXd> llt =
      FactorInPriorUnits(left.A(coefficients_, coefficients_), process_->prior_sigma);
  const auto m = static_cast<Index>(coefficients_.size());
  return ConditionOnPrior(left, coefficients_, process_->prior_sigma,
                          llt.solve(MatrixXd::Identity(m, m)));
}

std::vector<EffectContribution> UnmodelledUnknowns::Contributions(
    const std::vector<Index>& angle_rows, bool corrected) const {
  const MatrixXd P = corrected ? covariance_ : MatrixXd(sigma_.cwiseAbs2().asDiagonal());
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
      part.sigma[at] = hypothesis.per_si * std::sqrt(covariance_(k, k));
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
  if (process_) {
    EffectContribution part = ProcessContribution(angle_rows);
    const double size = part.angle_sigma_rad.maxCoeff();
    all.emplace_back(size, std::move(part));
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<EffectContribution> sorted;
  for (auto& [size, part] : all) sorted.push_back(std::move(part));
  return sorted;
}

EffectContribution UnmodelledUnknowns::ProcessContribution(
    const std::vector<Index>& angle_rows) const {
  const EffectId id = EffectId::kGnssCorrelatedNoise;
  EffectContribution part;
  part.effect = EffectName(id);
  part.unit = MakeHypothesis(id).unit;
  part.remedy = ReduceWords(id);
  const auto sizes = [](double size, double tau_s) {
    Eigen::VectorXd values(4);
    values << size * GnssProcessPrior::Axes(), tau_s;
    return values;
  };
  part.estimate = sizes(process_->size.mean, process_->tau_s.mean);
  part.sigma = sizes(process_->size.sigma(), process_->tau_s.sigma());
  part.prior = sizes(process_->size_before.mean, process_->tau_before_s.mean);
  Eigen::Vector3d variance = Eigen::Vector3d::Zero();
  for (const Index row : angle_rows) {
    const MatrixXd shift = score_.shift.middleRows<3>(row);
    const MatrixXd S = shift(Eigen::all, coefficients_) + shift(Eigen::all, fixed_) * response_;
    variance += (S * process_->covariance).cwiseProduct(S).rowwise().sum();
  }
  part.angle_sigma_rad =
      (variance / static_cast<double>(angle_rows.size())).cwiseMax(0.0).cwiseSqrt();
  return part;
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
