#include "effects/physics.h"

namespace dn::effects {
namespace {

/// Draws outliers: zero in most cases, else a vector with random direction and with a length
/// uniform between 0 and the size.
class GrossError {
 public:
  explicit GrossError(const EffectInput& input)
      : share_(input.value[0]), size_m_(input.value[1]), random_(input.MakeRandom()) {}

  Eigen::Vector3d Next() {
    const bool wrong = random_.Uniform() < share_;
    const double length_m = size_m_ * random_.Uniform();
    const Eigen::Vector3d direction = random_.Normal3().normalized();
    return wrong ? Eigen::Vector3d(length_m * direction) : Eigen::Vector3d::Zero();
  }

 private:
  double share_, size_m_;
  Random random_;
};

}  // namespace

void GnssOutliers(const EffectInput& input, ActiveEffects* active) {
  active->antenna_enu_m.emplace_back(
      [error = GrossError(input)](double, double) mutable { return error.Next(); });
}

void P2pOutliers(const EffectInput& input, ActiveEffects* active) {
  active->pairs.emplace_back(
      [error = GrossError(input)](LidarPair* pair) mutable { pair->u_j_s += error.Next(); });
}

}  // namespace dn::effects
