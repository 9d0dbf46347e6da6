#pragma once

#include <dn/adjustment/adjust.h>
#include <dn/report/json.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace dn {

/// Forward minus reverse filter solution at one time.
struct SeparationAt {
  double t_s = 0.0;
  Eigen::Vector3d position_enu_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d rph_rad = Eigen::Vector3d::Zero();  ///< roll, pitch, heading
};

/// Separation of two diffuse-prior filters over the same data, one started at the beginning of the
/// flight and one at its end. They are compared at the GNSS epochs, after the measurement update.
/// This quality measure of the trajectory needs no stochastic model.
///
/// Both filters share the measurement of the epoch and the priors of the biases. The separation is
/// therefore not a standard deviation of the smoothed trajectory, which is more accurate than
/// either filter.
struct FilterSeparation {
  /// The epochs at which both filters have aligned: the sigma of heading is below a tenth of its
  /// initial value. They are in time order; empty if the flight does not turn enough.
  std::vector<SeparationAt> epochs;

  SeparationAt Rms() const;  ///< t_s is not set
  SeparationAt Max() const;  ///< maximum of the absolute values per axis; t_s is not set
};

/// Runs the forward and the reverse filter over the data used by the adjustment, and returns their
/// differences.
FilterSeparation SeparateFilters(const Adjustment& adjustment);

/// Returns {"epochs", "rms_enu_m", "max_enu_m", "rms_rph_deg", "max_rph_deg"}; null without epochs.
Json SeparationJson(const FilterSeparation& separation);

/// Returns the text of filter_separation.txt: t, forward minus reverse E, N, U [m], roll, pitch,
/// heading [deg].
std::string FormatSeparation(const FilterSeparation& separation);

}  // namespace dn
