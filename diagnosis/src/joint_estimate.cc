#include "joint_estimate.h"

#include "evidence.h"

namespace dn::diagnosis_internal {
namespace {

bool IsFixed(const HypothesisEvidence& effect) {
  return !effect.id || EffectRow(*effect.id).fixed();
}

}  // namespace

JointColumns CombineFixed(const std::vector<HypothesisEvidence>& effects, const JointScore& score) {
  JointColumns out;
  out.T.resize(score.s.size(), 0);
  for (const HypothesisEvidence& effect : effects) {
    if (!IsFixed(effect)) continue;
    const Eigen::Index n = effect.typical.size(), before = out.T.cols();
    const CellRange cells = effect.cells.value_or(CellRange{0, 1});
    out.T.conservativeResize(Eigen::NoChange, before + n);
    out.T.rightCols(n).setZero();
    for (int k = cells.first; k < cells.past; ++k) {
      out.T.block(score.first[effect.block] + n * k, before, n, n).setIdentity();
    }
    out.typical.conservativeResize(before + n);
    out.typical.tail(n) = effect.typical;
  }
  return out;
}

void TakeJointEstimates(const ScoreTest& test, std::vector<HypothesisEvidence>* effects) {
  const Eigen::VectorXd sigma = ComponentSigmas(test);
  Eigen::Index first = 0;
  for (HypothesisEvidence& effect : *effects) {
    if (!IsFixed(effect)) continue;
    const Eigen::Index n = effect.typical.size();
    effect.estimate = test.estimate.segment(first, n);
    effect.sigma = sigma.segment(first, n);
    first += n;
  }
}

}  // namespace dn::diagnosis_internal
