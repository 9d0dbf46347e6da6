#pragma once

#include <dn/adjustment/gauss_helmert_flight.h>
#include <dn/adjustment/pose_interpolator.h>
#include <dn/report/json.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace dn {

/// Time, scan angle, range and heading at one end of a pair.
struct ResidualEnd {
  double t_s = 0.0;             ///< time tag in the file
  double scan_angle_rad = 0.0;  ///< from the function ScanAngle
  double range_m = 0.0;
  double heading_rad = 0.0;  ///< heading of the body
};

/// Difference p_i - p_j of the two points of a kept pair; east, north, up of the map origin, m.
struct PairResidual {
  ResidualEnd i, j;
  std::string strips;            ///< from the function StripPairName
  Eigen::Vector3d ground_m;      ///< midpoint of the two points in the mapping frame
  Eigen::Vector3d before_enu_m;  ///< with the assumed mounting, on the resulting trajectory
  Eigen::Vector3d after_enu_m;   ///< with the resulting mounting and trajectory
};

/// Returns the residuals of the kept pairs of a solved network, in the order of its edges. `poses`
/// interpolates its own trajectory (DenseTrajectory).
std::vector<PairResidual> PairResiduals(const FlightNetwork& network,
                                        const PoseInterpolator& poses);

/// Returns the residuals of the kept pairs of a Gauss-Helmert adjustment, on its given trajectory.
std::vector<PairResidual> PairResiduals(const Flight& flight,
                                        const GaussHelmertCalibration& calibration);

/// Returns the text of pair_residuals.txt. Its columns are
///
///   t_i, t_j [s];   number of the strip pair in StripPairsJson, from 1
///   ground east, north [m];   before east, north, up [m];   after east, north, up [m]
///   scan angle i, j [deg];   range i, j [m];   heading i, j [deg]
std::string FormatPairResiduals(const std::vector<PairResidual>& residuals);

/// Returns an array with one object per strip pair, in the order of their first pairs, and a last
/// one for "all". An object has `strips`, `pairs`, `before` and `after`. Each of the last two has
/// `mean_enu_m`, `rms_enu_m`, the mean length of the differences `mean_m`, and `separation`
/// (SwathSeparation).
Json StripPairsJson(const std::vector<PairResidual>& residuals);

}  // namespace dn
