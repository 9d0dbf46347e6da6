#include <dn/geo/text_coordinates.h>
#include <dn/geo/text_table.h>

#include <cmath>
#include <utility>

namespace dn {
namespace {

/// Throws InvalidInput for grid coordinates that are so small that they must be degrees.
void ExpectNoDegrees(const double* c, const std::string& key, const FileLocation& where) {
  if (std::abs(c[0]) > 360.0 || std::abs(c[1]) > 360.0) return;
  throw InvalidInput("easting, northing are " + FormatDouble(c[0]) + ", " + FormatDouble(c[1]) +
                         " m; if these are degrees, set " + key + ": geographic",
                     where);
}

}  // namespace

bool TextCoordinates::IsName(const std::string& crs) {
  return crs == "geographic" || (crs != "none" && IsPointCrsName(crs));
}

TextCoordinates::TextCoordinates(const std::string& crs, const std::optional<Geodetic>& map_origin,
                                 std::string key)
    : key_(std::move(key)), frame_(map_origin.value_or(Geodetic())) {
  if (crs == "geographic") return;
  if (crs == "map" && !map_origin) {
    throw InvalidConfig(key_ + ": map needs frame.origin_deg_m, the origin of its coordinates");
  }
  crs_.emplace(crs, frame_);
  utm_ = crs.rfind("utm:", 0) == 0;
}

Geodetic TextCoordinates::Read(const double* columns, const FileLocation& where) const {
  if (crs_) {
    if (utm_) ExpectNoDegrees(columns, key_, where);
    try {
      return frame_.ToGeodetic(crs_->ToMap({columns[0], columns[1], columns[2]}));
    } catch (const InvalidInput& error) {
      throw InvalidInput(error.what(), where);
    }
  }
  const Geodetic point{columns[0] * kRadPerDeg, columns[1] * kRadPerDeg, columns[2]};
  CheckGeodetic(point, where);
  return point;
}

double TextCoordinates::Convergence_rad(const Geodetic& point) const {
  const Eigen::Vector3d p_m = frame_.ToMap(point);
  const Eigen::Vector3d north_c = crs_->J_c_m(p_m) * frame_.R_mn(p_m).col(0);
  return -std::atan2(north_c.x(), north_c.y());
}

}  // namespace dn
