#include <dn/rotation.h>

#include "effects/physics.h"

namespace dn::effects {
namespace {

using Triad = Eigen::Vector3d ImuSample::*;

/// If the axes are rotated by the value, they measure the true vector rotated by its opposite.
auto Turned(const EffectInput& input, Triad triad) {
  const Eigen::Matrix3d turn = Exp(Eigen::Vector3d(-input.value)).toRotationMatrix();
  return [turn, triad](const ImuSample&, ImuSample* sample) {
    sample->*triad = turn * (sample->*triad);
  };
}

}  // namespace

void GyroMisalignment(const EffectInput& input, ActiveEffects* active) {
  active->triads.emplace_back(Turned(input, &ImuSample::w_ib_b_radps));
}

void AccelMisalignment(const EffectInput& input, ActiveEffects* active) {
  active->triads.emplace_back(Turned(input, &ImuSample::f_b_mps2));
}

}  // namespace dn::effects
