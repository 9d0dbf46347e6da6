#pragma once

#include <dn/effects/unmodelled_prior.h>

#include <vector>

namespace dn {

struct FlightConfig;

/// Size of an effect that the model leaves out.
struct UnmodelledSize {
  EffectId effect;
  /// One sigma per component, or one for all components, in the unit of the effect table.
  std::vector<double> sigma;
};

/// Section `unmodelled`.
struct UnmodelledConfig {
  bool none = false;  ///< true: the pure model, without any of these effects
  /// Effects whose sizes differ from the default of the sensor's class.
  std::vector<UnmodelledSize> sizes;
};

/// Returns the prior of the effects that a flight's model leaves out. It is that of the class of
/// its inertial unit, with the sizes that the section `unmodelled` states. The class follows from
/// imu.grade, or else from imu.gyro.white_deg_sqrt_h. It is navigation without a section `imu`.
UnmodelledPrior MakeUnmodelledPrior(const FlightConfig& config);

}  // namespace dn
