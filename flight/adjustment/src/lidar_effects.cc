#include <dn/adjustment/lidar_effects.h>
#include <dn/effects/effect_table.h>

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <variant>

namespace dn {
namespace {

using Eigen::MatrixXd;

/// d residual / d effect through one end of a pair.
using EndModel = std::function<MatrixXd(const PairEnd&)>;

EffectModel MakeEffectModel(const std::vector<PairEnds>& pairs, const EndModel& end) {
  EffectModel model;
  for (const PairEnds& pair : pairs) model.push_back({pair.factor, end(pair.i) + end(pair.j)});
  return model;
}

MatrixXd EndDerivative(const LidarEffect& effect, const PairEnd& end) {
  const int n = effect.components();
  LidarReading reading = LidarReading::Uncorrected(end.t_s, end.u_s, n);
  effect.Correct(Eigen::VectorXd::Zero(n), 0, &reading);
  return end.J_r_u * reading.J_u + end.J_r_turn * reading.J_turn + end.J_r_a * reading.J_arm +
         end.J_r_t * reading.J_delay;
}

EndModel MakeEndModel(const EffectAction& action) {
  return [effect = std::get<std::shared_ptr<const LidarEffect>>(action)](const PairEnd& e) {
    return EndDerivative(*effect, e);
  };
}

}  // namespace

CandidateEffect MakePairCandidate(const UserEffect& own, const std::vector<PairEnds>& pairs) {
  CandidateEffect effect;
  effect.name = own.name;
  effect.typical = own.typical;
  effect.model = MakeEffectModel(pairs, MakeEndModel(own.action));
  return effect;
}

CandidateEffect MakePairCandidate(const EstimableEffect& effect, const Flight& flight,
                                  const std::vector<PairEnds>& pairs) {
  CandidateEffect candidate = DescribeEffect(effect);
  candidate.model = MakeEffectModel(pairs, MakeEndModel(effect.make({flight})));
  return candidate;
}

std::vector<CandidateEffect> MakeScannerEffects(const Flight& flight,
                                                const std::vector<PairEnds>& pairs) {
  std::vector<CandidateEffect> effects;
  for (const EstimableEffect& effect : EstimableEffects()) {
    const bool of_mount =
        effect.id == EffectId::kBoresightDrift || effect.id == EffectId::kBoresightStep;
    if (EffectRow(effect.id).sensor != EffectSensor::kLidar || of_mount) continue;
    effects.push_back(MakePairCandidate(effect, flight, pairs));
    effects.back().remedy += " with the dynamic network";
  }
  return effects;
}

}  // namespace dn
