#include "score_selection.h"

#include <dn/distributions.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <string>
#include <utility>

#include "forward_selection.h"
#include "joint_estimate.h"

namespace dn::diagnosis_internal {
namespace {

/// The scores of a library with the chosen effects among the unknowns.
struct ScoreFit : ExtendedFit {
  JointScore score;
};

/// Returns the significant effect with the most evidence; null if there is none.
const HypothesisEvidence* LikeliestSignificant(const std::vector<HypothesisEvidence>& effects) {
  const HypothesisEvidence* best = nullptr;
  for (const HypothesisEvidence& effect : effects) {
    if (effect.p_value > kFamilyLevel) continue;
    if (best == nullptr || effect.log_evidence > best->log_evidence) best = &effect;
  }
  return best;
}

/// Returns the effect that has the columns of a hypothesis; null if it is not in the list.
const HypothesisEvidence* FindBlock(const std::vector<HypothesisEvidence>& effects,
                                    const Hypothesis& hypothesis) {
  const auto at = std::find_if(effects.begin(), effects.end(), [&](const auto& effect) {
    return effect.block == hypothesis.block;
  });
  return at == effects.end() ? nullptr : &*at;
}

/// Returns the names of effects that are nearly as likely as the added one, and no longer
/// significant once it is in the model.
std::vector<std::string> InseparableEffects(const ExtendedFit& without, const ExtendedFit& with,
                                            const HypothesisEvidence& added) {
  std::vector<std::string> names;
  for (const HypothesisEvidence& other : without.effects) {
    if (other.id == added.id) continue;
    if (other.log_evidence < added.log_evidence - kEquallyLikelyNats) continue;
    if (FindBlock(with.effects, other)->p_value <= kFamilyLevel) continue;
    if (std::find(names.begin(), names.end(), other.name) == names.end()) {
      names.push_back(other.name);
    }
  }
  return names;
}

/// Estimates all chosen effects jointly, and computes the shift by each of them.
void EstimateTogether(const JointScore& score, const TestFamily& family, ScoreSelection* out) {
  out->joint = Eigen::VectorXd::Zero(score.s.size());
  if (out->chosen.empty()) return;
  const JointColumns columns = CombineFixed(out->chosen, score);
  const ScoreTest test = columns.Test(score);
  TakeJointEstimates(test, &out->chosen);
  out->joint = columns.T * test.estimate;
  const Eigen::VectorXd shrunk =
      columns.T * ShrunkEstimate(columns.Information(score), columns.Score(score), columns.typical);
  for (std::size_t k = 0; k < out->chosen.size(); ++k) {
    const HypothesisEvidence& effect = out->chosen[k];
    const Eigen::VectorXd shift = SelectShift(effect, score) * SelectScore(effect, score, shrunk);
    EffectCheck& check = out->effects[k];
    check.estimate = effect.per_si * effect.estimate;
    check.sigma = effect.per_si * effect.sigma;
    check.max_shift_sigmas = family.InSigmas(shift);
    check.boresight_rad = family.BoresightShift(shift);
  }
}

class ScoreSelector {
 public:
  ScoreSelector(const Library& library, const JointScore& score, const TestFamily& family)
      : hypotheses_(library.hypotheses), score_(score), family_(family) {}

  ScoreSelection Run() {
    std::unique_ptr<ScoreFit> base = Evaluate(score_, {});
    last_ = base.get();
    SelectionPolicy policy;
    policy.threshold_nats = std::numeric_limits<double>::lowest();
    policy.next = LikeliestSignificant;
    ForwardSelection selection(
        policy, [this](const auto& chosen) { return Add(chosen); }, std::move(base));
    selection.Grow();
    out_.left = last_->score;
    out_.chosen = selection.Take().chosen;
    EstimateTogether(score_, family_, &out_);
    return std::move(out_);
  }

 private:
  /// Evaluates the effects of the table that are not chosen.
  std::unique_ptr<ScoreFit> Evaluate(JointScore score,
                                     const std::vector<HypothesisEvidence>& chosen) const {
    auto fit = std::make_unique<ScoreFit>();
    for (const Hypothesis& hypothesis : hypotheses_) {
      if (!hypothesis.id || FindBlock(chosen, hypothesis) != nullptr) continue;
      HypothesisEvidence effect{hypothesis, {}};
      const ScoreTest test = TestHypothesis(hypothesis, score);
      if (test.dof > 0) {
        effect.p_value = family_.FamilyWise(ChiSquareTail(test.statistic, test.dof));
      }
      effect.log_evidence = LogEvidence(hypothesis, score);
      fit->effects.push_back(std::move(effect));
    }
    fit->chosen = chosen;
    fit->score = std::move(score);
    return fit;
  }

  /// Adds the last of the chosen effects to the unknowns.
  std::unique_ptr<ScoreFit> Add(const std::vector<HypothesisEvidence>& chosen) {
    const HypothesisEvidence& added = chosen.back();
    std::unique_ptr<ScoreFit> with =
        Evaluate(ConditionOn(last_->score, CombineFixed({added}, last_->score).T), chosen);
    EffectCheck check;
    check.name = added.name;
    check.unit = added.unit;
    check.remedy = added.remedy;
    check.p_value = added.p_value;
    check.log_evidence = added.log_evidence;
    check.inseparable_from = InseparableEffects(*last_, *with, added);
    out_.effects.push_back(std::move(check));
    out_.tests.push_back(TestHypothesis(added, last_->score));
    last_ = with.get();
    return with;
  }

  const std::vector<Hypothesis>& hypotheses_;
  const JointScore& score_;
  const TestFamily& family_;
  const ScoreFit* last_ = nullptr;  // with the effects selected so far
  ScoreSelection out_;
};

}  // namespace

ScoreSelection SelectByScores(const Library& library, const JointScore& score,
                              const TestFamily& family) {
  return ScoreSelector(library, score, family).Run();
}

ScoreSelection Keep(const ScoreSelection& selection, const std::vector<std::size_t>& kept,
                    const JointScore& score, const TestFamily& family) {
  ScoreSelection out;
  for (const std::size_t k : kept) {
    out.effects.push_back(selection.effects[k]);
    out.chosen.push_back(selection.chosen[k]);
    out.tests.push_back(selection.tests[k]);
  }
  out.left = kept.empty() ? score : ConditionOn(score, CombineFixed(out.chosen, score).T);
  EstimateTogether(score, family, &out);
  return out;
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

}  // namespace dn::diagnosis_internal
