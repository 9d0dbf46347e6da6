#include "score_selection.h"

#include <dn/report/distributions.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

namespace dn::internal {
namespace {

constexpr std::size_t kMaxSelectedEffects = 4;

class ScoreSelector {
 public:
  ScoreSelector(const Library& library, const JointScore& score, const TestFamily& family)
      : hypotheses_(library.hypotheses), score_(score), family_(family) {}

  ScoreSelection Run() {
    JointScore& left = out_.left = score_;
    out_.joint = Eigen::VectorXd::Zero(score_.s.size());
    while (out_.chosen.size() < kMaxSelectedEffects) {
      const std::optional<std::size_t> best = Likeliest(left);
      if (!best) break;
      EffectCheck effect = Describe(left, hypotheses_[*best]);
      JointScore given = ConditionOnComponents(left, hypotheses_[*best].Components(left));
      effect.inseparable_from = AlsoExplain(left, given, *best, effect.log_evidence);
      out_.chosen.push_back(*best);
      out_.effects.push_back(std::move(effect));
      left = std::move(given);
    }
    if (!out_.chosen.empty()) EstimateTogether();
    return std::move(out_);
  }

 private:
  double PValue(const JointScore& score, const Hypothesis& hypothesis) const {
    const ScoreTest test = TestHypothesis(hypothesis, score);
    return test.dof > 0 ? family_.FamilyWise(ChiSquareTail(test.statistic, test.dof)) : 1.0;
  }

  /// Returns the significant effect with the most evidence, if there is one.
  std::optional<std::size_t> Likeliest(const JointScore& score) const {
    std::optional<std::size_t> best;
    double most = 0.0;
    for (std::size_t k = 0; k < hypotheses_.size(); ++k) {
      if (!hypotheses_[k].id) continue;
      if (std::find(out_.chosen.begin(), out_.chosen.end(), k) != out_.chosen.end()) continue;
      if (PValue(score, hypotheses_[k]) > kFamilyLevel) continue;
      const double evidence = LogEvidence(hypotheses_[k], score);
      if (best && evidence <= most) continue;
      best = k;
      most = evidence;
    }
    return best;
  }

  EffectCheck Describe(const JointScore& score, const Hypothesis& hypothesis) const {
    EffectCheck effect;
    effect.name = hypothesis.name;
    effect.unit = hypothesis.unit;
    effect.remedy = hypothesis.remedy;
    effect.p_value = PValue(score, hypothesis);
    effect.log_evidence = LogEvidence(hypothesis, score);
    return effect;
  }

  /// Returns the names of effects that are nearly as likely and no longer significant if `chosen`
  /// is estimated.
  std::vector<std::string> AlsoExplain(const JointScore& score, const JointScore& given,
                                       std::size_t chosen, double evidence) const {
    std::vector<std::string> names;
    for (const Hypothesis& other : hypotheses_) {
      if (!other.id || other.id == hypotheses_[chosen].id) continue;
      if (LogEvidence(other, score) < evidence - kEquallyLikelyNats) continue;
      if (PValue(given, other) <= kFamilyLevel) continue;
      if (std::find(names.begin(), names.end(), other.name) == names.end()) {
        names.push_back(other.name);
      }
    }
    return names;
  }

  /// Estimates all found effects jointly, and computes the shift by each of them.
  void EstimateTogether() {
    std::vector<Eigen::Index> components;
    std::vector<double> typical;
    for (const std::size_t k : out_.chosen) {
      const Hypothesis& hypothesis = hypotheses_[k];
      for (const Eigen::Index c : hypothesis.Components(score_)) components.push_back(c);
      typical.insert(typical.end(), hypothesis.typical.begin(), hypothesis.typical.end());
    }
    const ScoreTest test = TestJointly(score_, components);
    const Eigen::VectorXd sigma = ComponentSigmas(test);
    const Eigen::VectorXd shrunk = ShrunkEstimate(
        score_.A(components, components), score_.s(components),
        Eigen::VectorXd::Map(typical.data(), static_cast<Eigen::Index>(typical.size())));
    Eigen::Index at = 0;
    for (std::size_t e = 0; e < out_.chosen.size(); ++e) {
      const Hypothesis& hypothesis = hypotheses_[out_.chosen[e]];
      const Eigen::Index q = hypothesis.typical.size();
      EffectCheck& effect = out_.effects[e];
      effect.estimate = hypothesis.per_si * test.estimate.segment(at, q);
      effect.sigma = hypothesis.per_si * sigma.segment(at, q);
      const Eigen::VectorXd shift = SelectShift(hypothesis, score_) * shrunk.segment(at, q);
      effect.max_shift_sigmas = family_.InSigmas(shift);
      effect.boresight_rad = family_.BoresightShift(shift);
      at += q;
    }
    out_.joint(components) = test.estimate;
  }

  const std::vector<Hypothesis>& hypotheses_;
  const JointScore& score_;
  const TestFamily& family_;
  ScoreSelection out_;
};

}  // namespace

ScoreSelection SelectByScores(const Library& library, const JointScore& score,
                              const TestFamily& family) {
  return ScoreSelector(library, score, family).Run();
}

std::vector<DiscrepancyCheck> CheckDiscrepancies(const Library& library, const JointScore& left,
                                                 double excess, const TestFamily& family) {
  std::vector<DiscrepancyCheck> checks;
  for (const Hypothesis& hypothesis : library.hypotheses) {
    if (hypothesis.id || library.blocks[hypothesis.block].empty()) continue;
    const ScoreTest test = TestHypothesis(hypothesis, left);
    if (test.dof == 0) continue;
    const Eigen::VectorXd shift =
        SelectShift(hypothesis, left) * ShrunkEstimate(SelectInformation(hypothesis, left),
                                                       SelectScore(hypothesis, left, left.s),
                                                       hypothesis.typical);
    DiscrepancyCheck check;
    check.name = hypothesis.name;
    check.statistic = test.statistic / excess;
    check.dof = test.dof;
    check.p_value = family.FamilyWise(ChiSquareTail(check.statistic, test.dof));
    check.max_shift_sigmas = family.InSigmas(shift);
    check.boresight_rad = family.BoresightShift(shift);
    checks.push_back(std::move(check));
  }
  return checks;
}

}  // namespace dn::internal
