#pragma once

#include <dn/calibration/gauss_helmert_flight.h>
#include <dn/calibration/pose_interpolator.h>
#include <dn/report/json.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace dn {

/// How one end of a pair was seen.
struct ResidualEnd {
  double t_s = 0.0;             ///< tag of the file
  double scan_angle_rad = 0.0;  ///< ScanAngle
  double range_m = 0.0;
  double heading_rad = 0.0;  ///< of the body
};

/// By how much the two points of a pair that an adjustment kept differ: p_i - p_j in m (east, north,
/// up of the origin), m.
struct PairResidual {
  ResidualEnd i, j;
  std::string strips;            ///< StripPairName
  Eigen::Vector2d ground_en_m;   ///< between the two points, east and north in m
  Eigen::Vector3d before_enu_m;  ///< with the assumed mounting, on the trajectory of the result
  Eigen::Vector3d after_enu_m;   ///< with the result
};

/// Of a solved network, for the pairs kept, in the order of its edges. `poses` are those of its own
/// trajectory (DenseTrajectory).
std::vector<PairResidual> PairResiduals(const FlightNetwork& network,
                                        const PoseInterpolator& poses);

/// Of a Gauss-Helmert adjustment, on its given trajectory.
std::vector<PairResidual> PairResiduals(const Flight& flight,
                                        const GaussHelmertCalibration& calibration);

/// pair_residuals.txt: t_i, t_j [s]; number of the pair of strips in StripPairsJson, from 1; ground
/// east, north [m]; before east, north, up [m]; after east, north, up [m]; scan angle i, j [deg];
/// range i, j [m]; heading i, j [deg].
std::string FormatPairResiduals(const std::vector<PairResidual>& residuals);

/// Per pair of strips, in order of their first pair: `strips`, `pairs`, and of `before` and `after`
/// the `mean_enu_m`, the `rms_enu_m`, the mean length of the differences `mean_m` and the
/// `separation` (SwathSeparation). Last, "all".
Json StripPairsJson(const std::vector<PairResidual>& residuals);

}  // namespace dn
