#pragma once

#include <dn/fleet/fleet.h>

#include <cstddef>
#include <vector>

#include "tie_likelihood.h"

namespace dn::fleet_internal {

/// Ties that agree with the flights, and the noise of their pairs.
struct ScreenedTies {
  std::vector<std::size_t> kept;
  double noise_factor = 1.0;         ///< multiplies the stated variances; at least 1
  std::vector<StripTies> by_strips;  ///< mean differences of the strips of two flights
};

/// Screens ties against what the flights alone predict. `mean` and `covariance` are those of all
/// unknowns without the ties.
///
/// Each tie is predicted from the flights and all other ties. The median of the normalised
/// squares may exceed that of chi-square(3) by chance, at 1 %. Beyond this, the noise factor makes
/// it the same. The worst tie is left out until none has a
/// p-value below 1 %, for the worst of all ties. `R_enu_e` turns ECEF into the axes of the mean
/// differences.
ScreenedTies ScreenTies(const std::vector<Tie>& ties, const TieDifferences& differences,
                        const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance,
                        const Eigen::Matrix3d& R_enu_e, const std::vector<ReducedFlight>& flights);

}  // namespace dn::fleet_internal
