#include "screen.h"

#include <dn/effects/effect_table.h>
#include <dn/log_sum.h>
#include <dn/report/distributions.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace dn::internal {
namespace {

std::vector<BlockId> Watched(const FlightNetwork& network, const LinearizedNetwork& linearized) {
  if (linearized.FirstColumn(network.calibration().boresight().id) < 0) return {};
  return {network.calibration().boresight().id};
}

}  // namespace

Screen::Screen(const FlightNetwork& network, const Marginals& marginals,
               const LibraryOptions& options)
    : library_(MakeLibrary(network, marginals.linearized(), options)),
      score_(ScoreEffects(marginals, library_.blocks, Watched(network, marginals.linearized()))) {
  MakeForms();
}

Screen::Screen(Library library, JointScore score)
    : library_(std::move(library)), score_(std::move(score)) {
  MakeForms();
}

void Screen::MakeForms() {
  for (std::size_t k = 0; k < library_.candidates.size(); ++k) {
    const Candidate& candidate = library_.candidates[k];
    forms_.emplace_back(CandidateInformation(candidate, score_), candidate.typical);
    if (families_.empty() || families_.back().name != candidate.name) {
      families_.push_back({candidate.name, candidate.id, k, k});
    }
    families_.back().past = k + 1;
  }
}

Eigen::MatrixXd Screen::Scores(const LinearizedNetwork& linearized,
                               const Eigen::MatrixXd& R) const {
  Eigen::MatrixXd s = Eigen::MatrixXd::Zero(score_.s.size(), R.cols());
  for (std::size_t b = 0; b < library_.blocks.size(); ++b) {
    const Eigen::MatrixXd of_block = TransposeTimes(linearized, library_.blocks[b], R);
    s.middleRows(score_.first[b], of_block.rows()) = of_block;
  }
  return s;
}

double Screen::LogEvidence(std::size_t candidate, const Eigen::VectorXd& s) const {
  return forms_[candidate].LogEvidence(CandidateScore(library_.candidates[candidate], score_, s));
}

double Screen::LogEvidence(const EffectFamily& family, const Eigen::VectorXd& s) const {
  LogSum sum;
  for (std::size_t k = family.first; k < family.past; ++k) sum.Add(LogEvidence(k, s));
  return sum.Value() - std::log(static_cast<double>(family.past - family.first));
}

ScoreTest Screen::Test(std::size_t candidate, const Eigen::VectorXd& s) const {
  const Candidate& of = library_.candidates[candidate];
  return TestScore(CandidateScore(of, score_, s), CandidateInformation(of, score_),
                   CandidateSignature(of, score_));
}

std::vector<ScreenedEffect> Screen::EffectsInOrder() const {
  std::vector<ScreenedEffect> effects;
  effects.reserve(families_.size());
  for (const EffectFamily& family : families_) effects.push_back(Describe(family));
  return effects;
}

std::vector<ScreenedEffect> Screen::Effects() const {
  std::vector<ScreenedEffect> effects = EffectsInOrder();
  SortByEvidence(&effects);
  return effects;
}

ScreenedEffect Screen::Describe(const EffectFamily& family) const {
  ScreenedEffect effect;
  effect.name = family.name;
  effect.id = family.id;
  LogSum sum;
  double best = kLogZero;
  for (std::size_t k = family.first; k < family.past; ++k) {
    const double one = LogEvidence(k, score_.s);
    sum.Add(one);
    if (one > best) {
      best = one;
      effect.candidate = k;
    }
  }
  effect.log_evidence = sum.Value() - std::log(static_cast<double>(family.past - family.first));
  const Candidate& candidate = library_.candidates[effect.candidate];
  effect.times = candidate.times;
  effect.period_s = candidate.period_s;
  effect.decay_s = candidate.decay_s;
  const ScoreTest test = Test(effect.candidate, score_.s);
  if (test.dof > 0) {
    effect.p_value = std::min(1.0, ChiSquareTail(test.statistic, test.dof) *
                                       static_cast<double>(family.past - family.first));
  }
  if (!candidate.tau_s) effect.statistic = test.statistic;
  const Eigen::VectorXd signature = CandidateSignature(candidate, score_);
  const Eigen::VectorXd weight = candidate.typical.cwiseAbs2();
  effect.absorbed = 1.0 - CandidateInformation(candidate, score_).diagonal().dot(weight) /
                              std::max(1e-300, signature.dot(weight));
  if (candidate.tau_s) {
    DescribeProcess(candidate, effect.candidate, &effect);
  } else {
    DescribeFixed(candidate, effect.candidate, &effect);
  }
  return effect;
}

void Screen::DescribeFixed(const Candidate& candidate, std::size_t index,
                           ScreenedEffect* effect) const {
  const ScoreTest test = Test(index, score_.s);
  effect->estimate = test.estimate;
  effect->sigma = test.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  if (score_.shift.rows() == 3) {
    effect->boresight_rad = CandidateShift(candidate, score_) * test.estimate;
  }
}

// Estimates the common factor of the sigmas, and its standard deviation from the curvature of the
// evidence.
void Screen::DescribeProcess(const Candidate& candidate, std::size_t index,
                             ScreenedEffect* effect) const {
  const Eigen::VectorXd s = CandidateScore(candidate, score_, score_.s);
  double best = -std::numeric_limits<double>::infinity(), variance = 1.0;
  for (int step = -40; step <= 40; ++step) {
    const double v = std::pow(10.0, 0.1 * step);
    const double evidence = forms_[index].LogEvidence(s, v);
    if (evidence > best) {
      best = evidence;
      variance = v;
    }
  }
  const double step = 0.05;  // of ln(variance)
  const double curvature = (2.0 * best - forms_[index].LogEvidence(s, variance * std::exp(step)) -
                            forms_[index].LogEvidence(s, variance * std::exp(-step))) /
                           (step * step);
  const double relative = 0.5 / std::sqrt(std::max(curvature, 1e-3));
  const EffectSpec& spec = *FindEffect(candidate.name);
  const auto sigmas = static_cast<Eigen::Index>(spec.components.size()) - 1;
  effect->estimate.resize(sigmas + 1);
  effect->sigma.resize(sigmas + 1);
  for (Eigen::Index k = 0; k < sigmas; ++k) {
    effect->estimate[k] =
        std::sqrt(variance) * spec.components[static_cast<std::size_t>(k)].typical_si();
    effect->sigma[k] = relative * effect->estimate[k];
  }
  effect->estimate[sigmas] = *candidate.tau_s;
  effect->sigma[sigmas] = std::numeric_limits<double>::quiet_NaN();
}

ScreenedEffect MakeUnscreened(EffectId id) {
  ScreenedEffect effect;
  effect.name = EffectName(id);
  effect.id = id;
  return effect;
}

void SortByEvidence(std::vector<ScreenedEffect>* effects) {
  std::stable_sort(effects->begin(), effects->end(),
                   [](const auto& a, const auto& b) { return a.log_evidence > b.log_evidence; });
}

GapCause ToCause(const ScreenedEffect& effect) {
  GapCause cause;
  cause.effect = effect.name;
  cause.times = effect.times;
  cause.log_evidence = effect.log_evidence;
  cause.p_value = effect.p_value;
  cause.absorbed_fraction = effect.absorbed;
  cause.boresight_shift_rad = effect.boresight_rad;
  cause.estimate = effect.estimate;
  cause.sigma = effect.sigma;
  const EffectSpec* spec = FindEffect(effect.name);
  if (spec == nullptr) return cause;
  cause.unit = spec->components[0].unit;
  for (Eigen::Index k = 0; k < cause.estimate.size(); ++k) {
    const double to_si = spec->components[static_cast<std::size_t>(k)].to_si;
    cause.estimate[k] /= to_si;
    cause.sigma[k] /= to_si;
  }
  return cause;
}

}  // namespace dn::internal
