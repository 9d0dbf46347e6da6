#include "effects.h"

namespace dn::builder_internal {

// Adds g times the value toward north and east to the gravity vector. The change is assigned to
// gravitation, because the centrifugal part depends only on the rotation of the Earth.
EffectAction GravityTilt(const EffectSite& site) {
  return GravitationField([frame = site.flight.frame](const Eigen::Vector3d& p_m) {
    Eigen::Matrix<double, 3, 2> north_east;
    north_east << 0.0, 1.0, 1.0, 0.0, 0.0, 0.0;
    return GravitationBasis(frame.Gravity(p_m).norm() * frame.R_m_enu(p_m) * north_east);
  });
}

// Adds the value to the magnitude of normal gravity, which points down.
EffectAction GravityDisturbance(const EffectSite& site) {
  return GravitationField([frame = site.flight.frame](const Eigen::Vector3d& p_m) {
    return GravitationBasis(frame.Gravity(p_m).normalized());
  });
}

}  // namespace dn::builder_internal
