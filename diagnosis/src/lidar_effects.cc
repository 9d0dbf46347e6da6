#include "lidar_effects.h"

#include <dn/effects/effect_table.h>

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <variant>

namespace dn::diagnosis_internal {
namespace {

using Eigen::MatrixXd;

/// d residual / d effect through one end of a pair.
using EndModel = std::function<MatrixXd(const PairEnd&)>;

MatrixXd EndDerivative(const LidarEffect& effect, const PairEnd& end) {
  const int n = effect.components();
  LidarReading reading = LidarReading::Uncorrected(end.t_s, end.u_s, n);
  effect.Correct(Eigen::VectorXd::Zero(n), 0, &reading);
  return end.J_r_u * reading.J_u + end.J_r_turn * reading.J_turn + end.J_r_a * reading.J_arm +
         end.J_r_t * reading.J_delay;
}

EndModel MakeEndModel(const Hypothesis& hypothesis) {
  return [effect = std::get<std::shared_ptr<const LidarEffect>>(hypothesis.action)](
             const PairEnd& e) { return EndDerivative(*effect, e); };
}

}  // namespace

EffectModel MakePairColumns(const Hypothesis& hypothesis, const std::vector<PairEnds>& pairs) {
  const EndModel end = MakeEndModel(hypothesis);
  EffectModel columns;
  for (const PairEnds& pair : pairs) columns.push_back({pair.factor, end(pair.i) + end(pair.j)});
  return columns;
}

Library MakeScannerHypotheses(const Flight& flight, const std::vector<PairEnds>& pairs) {
  Library library;
  for (const EstimableEffect& effect : EstimableEffects()) {
    const bool of_mount =
        effect.id == EffectId::kBoresightDrift || effect.id == EffectId::kBoresightStep;
    if (EffectRow(effect.id).sensor != EffectSensor::kLidar || of_mount) continue;
    Hypothesis hypothesis = MakeHypothesis(effect, {flight});
    hypothesis.remedy += " with the dynamic network";
    library.Add(hypothesis, MakePairColumns(hypothesis, pairs));
  }
  return library;
}

}  // namespace dn::diagnosis_internal
