#pragma once

#include <dn/calibration/gauss_helmert_flight.h>

#include <Eigen/Core>
#include <vector>

namespace dn::internal {

/// Effects that the pairs of a Gauss-Helmert calibration show.
struct GaussHelmertEffects {
  std::vector<EffectCheck> effects;
  std::vector<DepartureCheck> departures;
  double share_left = 1.0;  ///< of the misclosures' sum of squares, with those among the unknowns
};

/// Score tests of the effects of the lidar, beside lasting errors of the trajectory.
///
/// An error of the trajectory that lasts looks like many an effect: a late tag shifts a strip along
/// its course. So the errors are unknowns, of the stated size or of a larger one: of the scale that
/// is the likeliest, with the likeliest effect or without any. With one, the likelihood counts
/// less, by the number of effects over the level of significance. Departures are those by scan angle:
/// what differs by strip, errors of the trajectory do as well.
GaussHelmertEffects FindEffects(const Flight& flight, const std::vector<StripInterval>& strips,
                                const GaussHelmertCalibration& calibration);

/// The boresight from its stated value, as a left rotation.
Eigen::Vector3d AwayFromStated(const GaussHelmertCalibration& calibration);

}  // namespace dn::internal
