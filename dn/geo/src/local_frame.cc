#include <dn/error.h>
#include <dn/geo/local_frame.h>
#include <dn/geo/text_table.h>

#include <GeographicLib/Geocentric.hpp>
#include <GeographicLib/LocalCartesian.hpp>
#include <GeographicLib/NormalGravity.hpp>
#include <algorithm>
#include <cmath>
#include <string>

namespace dn {
namespace {

double LatitudeDeg(const Geodetic& point) {
  return std::clamp(point.lat_rad * kDegPerRad, -90.0, 90.0);
}

Eigen::Matrix3d R_enu_ned() { return (Eigen::Matrix3d() << 0, 1, 0, 1, 0, 0, 0, 0, -1).finished(); }

}  // namespace

Eigen::Matrix3d R_en(const Geodetic& point) {
  const double sin_lat = std::sin(point.lat_rad), cos_lat = std::cos(point.lat_rad);
  const double sin_lon = std::sin(point.lon_rad), cos_lon = std::cos(point.lon_rad);
  Eigen::Matrix3d R;
  R << -sin_lat * cos_lon, -sin_lon, -cos_lat * cos_lon,  //
      -sin_lat * sin_lon, cos_lon, -cos_lat * sin_lon,    //
      cos_lat, 0.0, -sin_lat;
  return R;
}

Eigen::Vector3d ToEcef(const Geodetic& point) {
  Eigen::Vector3d p_e;
  GeographicLib::Geocentric::WGS84().Forward(LatitudeDeg(point), point.lon_rad * kDegPerRad,
                                             point.h_m, p_e.x(), p_e.y(), p_e.z());
  return p_e;
}

Geodetic GeodeticFromEcef(const Eigen::Vector3d& p_e) {
  double lat_deg = 0.0, lon_deg = 0.0, h_m = 0.0;
  GeographicLib::Geocentric::WGS84().Reverse(p_e.x(), p_e.y(), p_e.z(), lat_deg, lon_deg, h_m);
  return {lat_deg * kRadPerDeg, lon_deg * kRadPerDeg, h_m};
}

void CheckGeodetic(const Geodetic& point, const FileLocation& where) {
  constexpr double kPi = std::numbers::pi;
  // Degrees converted to radians may exceed the bound by rounding.
  constexpr double kRounding = 1e-12;
  constexpr double kMostHeightM = 1e6;
  if (!(std::abs(point.lat_rad) <= kPi / 2 + kRounding)) {
    throw InvalidInput("latitude is " + FormatDouble(point.lat_rad * kDegPerRad) +
                           " deg, must be within -90 and 90 deg: are latitude and longitude "
                           "exchanged, or is this in "
                           "metres?",
                       where);
  }
  if (!(point.lon_rad >= -kPi - kRounding && point.lon_rad <= 2 * kPi + kRounding)) {
    throw InvalidInput("longitude is " + FormatDouble(point.lon_rad * kDegPerRad) +
                           " deg, must be within -180 and 360 deg",
                       where);
  }
  if (!(std::abs(point.h_m) <= kMostHeightM)) {
    throw InvalidInput(
        "ellipsoidal height is " + FormatDouble(point.h_m) + " m, must be within -1e6 and 1e6 m",
        where);
  }
}

struct LocalFrame::Data {
  explicit Data(const Geodetic& o)
      : origin(o),
        cartesian(LatitudeDeg(o), o.lon_rad * kDegPerRad, o.h_m),
        R_me(R_enu_ned() * R_en(o).transpose()),
        w_ie_m(R_me.col(2) * kEarthRateRadps),
        r0_m(R_me * ToEcef(o)) {}

  Geodetic origin;
  GeographicLib::LocalCartesian cartesian;
  Eigen::Matrix3d R_me;
  Eigen::Vector3d w_ie_m;
  Eigen::Vector3d r0_m;
};

LocalFrame::LocalFrame(const Geodetic& origin) {
  CheckGeodetic(origin);
  data_ = std::make_shared<const Data>(origin);
}

const Geodetic& LocalFrame::origin() const { return data_->origin; }
const Eigen::Matrix3d& LocalFrame::R_me() const { return data_->R_me; }
const Eigen::Vector3d& LocalFrame::w_ie_m() const { return data_->w_ie_m; }
const Eigen::Vector3d& LocalFrame::r0_m() const { return data_->r0_m; }

Eigen::Vector3d LocalFrame::ToMap(const Geodetic& point) const {
  Eigen::Vector3d p_m;
  data_->cartesian.Forward(LatitudeDeg(point), point.lon_rad * kDegPerRad, point.h_m, p_m.x(),
                           p_m.y(), p_m.z());
  return p_m;
}

Geodetic LocalFrame::ToGeodetic(const Eigen::Vector3d& p_m) const {
  double lat_deg = 0.0, lon_deg = 0.0, h_m = 0.0;
  data_->cartesian.Reverse(p_m.x(), p_m.y(), p_m.z(), lat_deg, lon_deg, h_m);
  return {lat_deg * kRadPerDeg, lon_deg * kRadPerDeg, h_m};
}

Eigen::Matrix3d LocalFrame::R_mn(const Eigen::Vector3d& p_m) const {
  return data_->R_me * R_en(ToGeodetic(p_m));
}

Eigen::Matrix3d LocalFrame::R_m_enu(const Eigen::Vector3d& p_m) const {
  return R_mn(p_m) * R_enu_ned().transpose();
}

Eigen::Vector3d LocalFrame::Gravitation(const Eigen::Vector3d& p_m) const {
  const Eigen::Vector3d p_e = data_->R_me.transpose() * (data_->r0_m + p_m);
  Eigen::Vector3d g_e;
  GeographicLib::NormalGravity::WGS84().V0(p_e.x(), p_e.y(), p_e.z(), g_e.x(), g_e.y(), g_e.z());
  return data_->R_me * g_e;
}

Eigen::Vector3d LocalFrame::Gravity(const Eigen::Vector3d& p_m) const {
  const Eigen::Vector3d p_e = data_->R_me.transpose() * (data_->r0_m + p_m);
  Eigen::Vector3d g_e;
  GeographicLib::NormalGravity::WGS84().U(p_e.x(), p_e.y(), p_e.z(), g_e.x(), g_e.y(), g_e.z());
  return data_->R_me * g_e;
}

}  // namespace dn
