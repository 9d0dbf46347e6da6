#pragma once

#include <dn/adjustment/control_checks.h>
#include <dn/adjustment/pair_residuals.h>
#include <dn/files/control.h>
#include <dn/geo/local_frame.h>
#include <dn/lidar/swath.h>

#include <string>
#include <vector>

namespace dn {

/// Layers for a geographic information system: GeoJSON (RFC 7946), longitude and latitude in
/// degrees on WGS84, and ellipsoidal heights in metres. A line or polygon that crosses the
/// meridian of 180 degrees continues beyond it.

/// Returns the text of swaths.geojson. Each strip has the path of the body as a line. The area that
/// it covers is a polygon at the mean height of the ground. Properties: `strip`, and `shows`
/// ("path" or "swath").
std::string FormatSwathLayer(const std::vector<Swath>& swaths, const LocalFrame& frame);

/// Returns the text of pairs.geojson: per pair its point on the ground. Properties: `strips`, times
/// `t_i_s` and `t_j_s`, and the difference of the two points east, north, up [m], `before_enu_m`
/// and `after_enu_m`. Of more than 20,000 pairs it has every second, third, ... one.
std::string FormatPairLayer(const std::vector<PairResidual>& pairs, const LocalFrame& frame);

/// Returns the text of control.geojson: per control point its surveyed place. Properties: `name`,
/// `role`, `residual_m` and `sigma_m` along `directions_enu`, and `p_value`.
std::string FormatControlLayer(const ControlCheck& check, const ControlData& control,
                               const LocalFrame& frame);

}  // namespace dn
