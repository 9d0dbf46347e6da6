#pragma once

#include <dn/adjustment/gauss_helmert_flight.h>
#include <dn/diagnosis/model_check.h>

#include <optional>
#include <vector>

namespace dn::diagnosis_internal {

/// Effects and unmodelled discrepancies that the pairs of a Gauss-Helmert calibration show.
struct GaussHelmertEffects {
  /// Effects of the lidar that the model leaves out; absent if their prior rules them out.
  std::optional<UnmodelledEffects> unmodelled;
  std::vector<EffectCheck> effects;
  std::vector<DiscrepancyCheck> discrepancies;
  /// Share of the misclosures' sum of squares that remains if `effects` are estimated.
  double share_left = 1.0;
};

/// Finds effects of the lidar by score tests, jointly with time-correlated errors of the
/// trajectory.
///
/// Such an error resembles many effects: a late tag, for example, shifts a strip along its course.
/// The errors are therefore unknowns, of the stated size or larger. Their scale is the likeliest
/// one, with the likeliest effect or without any. With an effect, the likelihood is reduced by the
/// number of effects over the significance level.
///
/// Unmodelled discrepancies are tested by scan angle only, because errors of the trajectory also
/// differ by strip.
GaussHelmertEffects FindEffects(const Flight& flight, const std::vector<StripInterval>& strips,
                                const GaussHelmertCalibration& calibration);

}  // namespace dn::diagnosis_internal
