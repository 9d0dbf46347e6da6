#include "antenna_error.h"

#include <cmath>

namespace dn {

AntennaError::AntennaError(const GnssProcess& process, const Random& random)
    : process_(process), random_(random), state_(random_.Normal3()) {}

Eigen::Vector3d AntennaError::operator()(double t_s, double roll_rad) {
  const double decay = last_s_ ? std::exp(-(t_s - *last_s_) / process_.tau_s) : 1.0;
  last_s_ = t_s;
  state_ = decay * state_ + std::sqrt(1.0 - decay * decay) * random_.Normal3();
  const bool with_bank = process_.growth == GnssErrorGrowth::kBank;
  const double size = with_bank ? std::abs(roll_rad) / kReferenceBankRad : 1.0;
  return size * process_.sigma_enu_m.cwiseProduct(state_);
}

}  // namespace dn
