#include "lidar_effects.h"

#include <dn/effects/effect_table.h>

#include <memory>
#include <string>
#include <utility>
#include <variant>

namespace dn::diagnosis_internal {
namespace {

using Eigen::MatrixXd;

MatrixXd EndDerivative(const LidarEffect& effect, const PairEnd& end) {
  const int n = effect.components();
  LidarReading reading = LidarReading::Uncorrected(end.t_s, end.u_s, n);
  effect.Correct(Eigen::VectorXd::Zero(n), 0, &reading);
  return end.J_r_u * reading.J_u + end.J_r_turn * reading.J_turn + end.J_r_a * reading.J_arm +
         end.J_r_t * reading.J_delay;
}

}  // namespace

Eigen::MatrixXd EndColumns(const Hypothesis& hypothesis, const PairEnd& end) {
  return EndDerivative(*std::get<std::shared_ptr<const LidarEffect>>(hypothesis.action), end);
}

EffectModel MakePairColumns(const Hypothesis& hypothesis, const std::vector<PairEnds>& pairs) {
  EffectModel columns;
  for (const PairEnds& pair : pairs) {
    columns.push_back(
        {pair.factor, EndColumns(hypothesis, pair.i) + EndColumns(hypothesis, pair.j)});
  }
  return columns;
}

std::vector<Hypothesis> ScannerHypotheses(const Flight& flight) {
  std::vector<Hypothesis> hypotheses;
  for (const EstimableEffect& effect : EstimableEffects()) {
    const bool of_mount =
        effect.id == EffectId::kBoresightDrift || effect.id == EffectId::kBoresightStep;
    if (EffectRow(effect.id).sensor != EffectSensor::kLidar || of_mount) continue;
    hypotheses.push_back(MakeHypothesis(effect, {flight}));
    hypotheses.back().remedy += " with the dynamic network";
  }
  return hypotheses;
}

Library MakeScannerHypotheses(const Flight& flight, const std::vector<PairEnds>& pairs) {
  Library library;
  for (const Hypothesis& hypothesis : ScannerHypotheses(flight)) {
    library.Add(hypothesis, MakePairColumns(hypothesis, pairs));
  }
  return library;
}

}  // namespace dn::diagnosis_internal
