#include "effects/physics.h"

namespace dn::effects {
namespace {

using Triad = Eigen::Vector3d ImuSample::*;

auto Scaled(const EffectInput& input, Triad triad) {
  const Eigen::Vector3d scale = input.value;
  return [scale, triad](const ImuSample&, ImuSample* sample) {
    sample->*triad += scale.cwiseProduct(sample->*triad);
  };
}

}  // namespace

void GyroScaleFactor(const EffectInput& input, ActiveEffects* active) {
  active->triads.emplace_back(Scaled(input, &ImuSample::w_ib_b_radps));
}

void AccelScaleFactor(const EffectInput& input, ActiveEffects* active) {
  active->triads.emplace_back(Scaled(input, &ImuSample::f_b_mps2));
}

}  // namespace dn::effects
