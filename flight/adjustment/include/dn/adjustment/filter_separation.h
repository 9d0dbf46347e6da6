#pragma once

#include <dn/calibration/adjust.h>
#include <dn/report/json.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace dn {

/// Forward filter minus reverse filter at one time.
struct SeparationAt {
  double t_s = 0.0;
  Eigen::Vector3d position_enu_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d rph_rad = Eigen::Vector3d::Zero();  ///< roll, pitch, heading
};

/// Two filters of the same data, one from the begin of the flight and one from its end, each with
/// an open mind about where it starts, compared after the GNSS epoch of each time: the trajectory's
/// quality figure that needs no stochastic model. Both share the measurement of that time and the
/// stated priors of the biases, so that it is no standard deviation of the smoothed trajectory, which
/// is better than either.
struct FilterSeparation {
  /// Where both have aligned: their sigma of heading is below a tenth of that of their start. In
  /// rising time; empty where the flight does not turn enough.
  std::vector<SeparationAt> epochs;

  SeparationAt Rms() const;  ///< t_s: of no meaning
  SeparationAt Max() const;  ///< per axis, absolute
};

FilterSeparation SeparateFilters(const Adjustment& adjustment);

/// {"epochs", "rms_enu_m", "max_enu_m", "rms_rph_deg", "max_rph_deg"}; null without epochs.
Json SeparationJson(const FilterSeparation& separation);

/// filter_separation.txt: t, forward minus reverse E, N, U [m], roll, pitch, heading [deg].
std::string FormatSeparation(const FilterSeparation& separation);

}  // namespace dn
