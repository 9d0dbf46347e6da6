#include <cmath>
#include <optional>

#include "effects/physics.h"

namespace dn::effects {
namespace {

/// Gauss-Markov in continuous time, taken at the epochs.
class Process {
 public:
  explicit Process(const EffectInput& input)
      : sigma_enu_m_(input.value.head<3>()),
        tau_s_(input.value[3]),
        random_(input.MakeRandom()),
        state_(random_.Normal3()) {}

  Eigen::Vector3d operator()(double t_s) {
    const double decay = last_s_ ? std::exp(-(t_s - *last_s_) / tau_s_) : 1.0;
    last_s_ = t_s;
    state_ = decay * state_ + std::sqrt(1.0 - decay * decay) * random_.Normal3();
    return sigma_enu_m_.cwiseProduct(state_);
  }

 private:
  Eigen::Vector3d sigma_enu_m_;
  double tau_s_;
  Random random_;
  Eigen::Vector3d state_;  // in sigmas
  std::optional<double> last_s_;
};

}  // namespace

void GnssCorrelatedNoise(const EffectInput& input, ActiveEffects* active) {
  active->antenna_enu_m.emplace_back(Process(input));
}

}  // namespace dn::effects
