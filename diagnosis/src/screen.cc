#include "screen.h"

#include <dn/distributions.h>
#include <dn/effects/effect_table.h>
#include <dn/log_sum.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "evidence.h"

namespace dn::diagnosis_internal {
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
  for (std::size_t k = 0; k < library_.hypotheses.size(); ++k) {
    const Hypothesis& hypothesis = library_.hypotheses[k];
    forms_.emplace_back(SelectInformation(hypothesis, score_), hypothesis.typical);
    if (families_.empty() || families_.back().name != hypothesis.name) {
      families_.push_back({hypothesis.name, hypothesis.id, k, k});
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
  return forms_[candidate].LogEvidence(SelectScore(library_.hypotheses[candidate], score_, s));
}

double Screen::LogEvidence(const EffectFamily& family, const Eigen::VectorXd& s) const {
  LogSum sum;
  for (std::size_t k = family.first; k < family.past; ++k) sum.Add(LogEvidence(k, s));
  return sum.Value() - std::log(static_cast<double>(family.past - family.first));
}

Eigen::VectorXd Screen::LogEvidences(const Eigen::VectorXd& s) const {
  Eigen::VectorXd evidences(static_cast<Eigen::Index>(families_.size()));
  for (std::size_t k = 0; k < families_.size(); ++k) {
    evidences[static_cast<Eigen::Index>(k)] = LogEvidence(families_[k], s);
  }
  return evidences;
}

std::vector<HypothesisEvidence> Screen::EffectsInOrder() const {
  std::vector<HypothesisEvidence> effects;
  effects.reserve(families_.size());
  for (const EffectFamily& family : families_) effects.push_back(Describe(family));
  return effects;
}

std::vector<HypothesisEvidence> Screen::Effects() const {
  std::vector<HypothesisEvidence> effects = EffectsInOrder();
  SortByEvidence(&effects);
  return effects;
}

HypothesisEvidence Screen::Describe(const EffectFamily& family) const {
  const auto members = static_cast<double>(family.past - family.first);
  LogSum sum;
  std::size_t best = family.first;
  double most = kLogZero;
  for (std::size_t k = family.first; k < family.past; ++k) {
    const double one = LogEvidence(k, score_.s);
    sum.Add(one);
    if (one <= most) continue;
    most = one;
    best = k;
  }
  HypothesisEvidence effect{library_.hypotheses[best], {}};
  effect.log_evidence = sum.Value() - std::log(members);
  const ScoreTest test = TestHypothesis(effect, score_);
  if (test.dof > 0) {
    effect.p_value = std::min(1.0, members * ChiSquareTail(test.statistic, test.dof));
  }
  const Eigen::VectorXd weight = effect.typical.cwiseAbs2();
  effect.absorbed = 1.0 - SelectInformation(effect, score_).diagonal().dot(weight) /
                              std::max(1e-300, SelectSignature(effect, score_).dot(weight));
  if (effect.tau_s) {
    EstimateProcess(forms_[best], &effect);
    return effect;
  }
  effect.statistic = test.statistic;
  effect.estimate = test.estimate;
  effect.sigma = ComponentSigmas(test);
  if (score_.shift.rows() == 3) effect.boresight_rad = SelectShift(effect, score_) * test.estimate;
  return effect;
}

// Estimates the common factor of the sigmas, and its standard deviation from the curvature of the
// evidence.
void Screen::EstimateProcess(const SizeAveragedEvidence& form, HypothesisEvidence* effect) const {
  const Eigen::VectorXd s = SelectScore(*effect, score_, score_.s);
  double best = -std::numeric_limits<double>::infinity(), variance = 1.0;
  for (int step = -40; step <= 40; ++step) {
    const double v = std::pow(10.0, 0.1 * step);
    const double evidence = form.LogEvidence(s, v);
    if (evidence > best) {
      best = evidence;
      variance = v;
    }
  }
  const double step = 0.05;  // of ln(variance)
  const double curvature = (2.0 * best - form.LogEvidence(s, variance * std::exp(step)) -
                            form.LogEvidence(s, variance * std::exp(-step))) /
                           (step * step);
  const double relative = 0.5 / std::sqrt(std::max(curvature, 1e-3));
  const double size = std::sqrt(variance);
  SetProcess({size, relative * size, *effect->tau_s, std::numeric_limits<double>::quiet_NaN()},
             effect);
}

}  // namespace dn::diagnosis_internal
