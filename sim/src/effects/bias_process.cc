#include <dn/sim/error_process.h>

#include "effects/physics.h"

namespace dn::effects {
namespace {

/// Simulates a Gauss-Markov process on each of three axes.
class Process {
 public:
  explicit Process(const EffectInput& input) : random_(input.MakeRandom()) {
    BiasProcess model;
    model.type = BiasProcess::Type::kGaussMarkov;
    model.sigma = input.value[0];
    model.tau_s = input.value[1];
    for (int axis = 0; axis < 3; ++axis) {
      axes_.emplace_back(model, 1.0 / input.scenario.imu.rate_hz, random_);
    }
  }

  Eigen::Vector3d operator()() {
    const double x = axes_[0].NextMean(random_), y = axes_[1].NextMean(random_);
    return {x, y, axes_[2].NextMean(random_)};
  }

 private:
  Random random_;
  std::vector<ErrorProcess> axes_;
};

}  // namespace

void GyroBiasProcess(const EffectInput& input, ActiveEffects* active) {
  active->gyro_bias.emplace_back(Process(input));
}

void AccelBiasProcess(const EffectInput& input, ActiveEffects* active) {
  active->accel_bias.emplace_back(Process(input));
}

}  // namespace dn::effects
