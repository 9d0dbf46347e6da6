#include <dn/error.h>
#include <dn/geo/point_crs.h>
#include <dn/geo/text_table.h>

#include <GeographicLib/TransverseMercator.hpp>
#include <cmath>
#include <memory>
#include <optional>

#include "crs_names.h"
#include "projected_crs.h"

namespace dn {
namespace {

constexpr double kFalseEastingM = 500e3;
constexpr double kFalseNorthingSouthM = 10e6;
constexpr double kMostNorthingM = 10e6;
constexpr double kMostHeightM = 1e6;
// Limits of the distance from the Earth's centre: from below the deepest mine to above any
// aircraft.
constexpr double kLeastRadiusM = 6.3e6, kMostRadiusM = 7.4e6;
// Limit of coordinates in the tangent plane.
constexpr double kMostMapM = 1e6;

[[noreturn]] void Fail(const std::string& what, const Eigen::Vector3d& p_c, const char* bounds) {
  throw InvalidInput("the point (" + FormatDouble(p_c.x()) + ", " + FormatDouble(p_c.y()) + ", " +
                     FormatDouble(p_c.z()) + ") m is not a valid point in " + what + ", " + bounds +
                     "; check strips_crs in flight.yaml");
}

void CheckUtm(const Eigen::Vector3d& p_c) {
  if (p_c.x() >= 0.0 && p_c.x() <= 2.0 * kFalseEastingM && p_c.y() >= 0.0 &&
      p_c.y() <= kMostNorthingM && std::abs(p_c.z()) <= kMostHeightM) {
    return;
  }
  Fail("UTM", p_c, "where the easting lies within 0 and 1e6 m, the northing within 0 and 1e7 m");
}

}  // namespace

PointCrs::PointCrs(const std::string& name, const LocalFrame& frame)
    : name_(ShortCrsName(name)), frame_(frame) {
  const geo_internal::CrsName parts = geo_internal::SplitCrsName(name_);
  height_unit_m_ = parts.height_unit_m;
  if (name_ == "map") return;
  if (name_ == "ecef") {
    kind_ = Kind::kEcef;
    return;
  }
  if (const auto definition = geo_internal::ProjDefinition(parts.system)) {
    kind_ = Kind::kProjected;
    projected_ = std::make_shared<const geo_internal::ProjectedCrs>(*definition);
    return;
  }
  const std::optional<geo_internal::UtmZone> utm = geo_internal::ParseUtm(parts.system);
  if (!utm) {
    throw InvalidConfig("'" + name + "' is not a coordinate system for points; use map, ecef, " +
                        "utm:ZONEn, utm:ZONEs (for example utm:32n) or epsg:CODE");
  }
  kind_ = Kind::kUtm;
  central_meridian_deg_ = 6.0 * utm->zone - 183.0;
  false_northing_m_ = utm->south ? kFalseNorthingSouthM : 0.0;
}

Eigen::Vector3d PointCrs::ToMap(const Eigen::Vector3d& p_c) const {
  return MetricToMap({p_c.x(), p_c.y(), p_c.z() * height_unit_m_});
}

Eigen::Vector3d PointCrs::FromMap(const Eigen::Vector3d& p_m) const {
  Eigen::Vector3d p_c = MetricFromMap(p_m);
  p_c.z() /= height_unit_m_;
  return p_c;
}

Eigen::Matrix3d PointCrs::J_c_m(const Eigen::Vector3d& p_m) const {
  Eigen::Matrix3d J = MetricJacobian(p_m);
  J.row(2) /= height_unit_m_;
  return J;
}

Eigen::Vector3d PointCrs::MetricToMap(const Eigen::Vector3d& p_c) const {
  switch (kind_) {
    case Kind::kUtm: {
      CheckUtm(p_c);
      double lat_deg = 0.0, lon_deg = 0.0;
      GeographicLib::TransverseMercator::UTM().Reverse(
          central_meridian_deg_, p_c.x() - kFalseEastingM, p_c.y() - false_northing_m_, lat_deg,
          lon_deg);
      return frame_.ToMap({lat_deg * kRadPerDeg, lon_deg * kRadPerDeg, p_c.z()});
    }
    case Kind::kEcef:
      if (!(p_c.norm() >= kLeastRadiusM && p_c.norm() <= kMostRadiusM)) {
        Fail("ECEF", p_c, "where the centre of the Earth is 6.3e6 to 7.4e6 m away");
      }
      return frame_.R_me() * p_c - frame_.r0_m();
    case Kind::kProjected: {
      const std::optional<Geodetic> point = projected_->ToGeodetic(p_c);
      if (!point) Fail("the coordinate system " + name_, p_c, "whose area does not contain it");
      return frame_.ToMap(*point);
    }
    case Kind::kMap:
      break;
  }
  if (!(p_c.cwiseAbs().maxCoeff() <= kMostMapM)) {
    Fail("the mapping frame", p_c, "where coordinates lie within 1e6 m of its origin");
  }
  return p_c;
}

Eigen::Vector3d PointCrs::MetricFromMap(const Eigen::Vector3d& p_m) const {
  switch (kind_) {
    case Kind::kUtm: {
      const Geodetic point = frame_.ToGeodetic(p_m);
      double x_m = 0.0, y_m = 0.0;
      GeographicLib::TransverseMercator::UTM().Forward(
          central_meridian_deg_, point.lat_rad * kDegPerRad, point.lon_rad * kDegPerRad, x_m, y_m);
      return {x_m + kFalseEastingM, y_m + false_northing_m_, point.h_m};
    }
    case Kind::kEcef:
      return frame_.R_me().transpose() * (frame_.r0_m() + p_m);
    case Kind::kProjected: {
      const auto p_c = projected_->FromGeodetic(frame_.ToGeodetic(p_m));
      if (!p_c) {
        throw InvalidInput("the flight lies outside of the coordinate system " + name_ +
                           "; check strips_crs in flight.yaml");
      }
      return *p_c;
    }
    case Kind::kMap:
      break;
  }
  return p_m;
}

Eigen::Matrix3d PointCrs::MetricJacobian(const Eigen::Vector3d& p_m) const {
  switch (kind_) {
    case Kind::kUtm: {
      const Geodetic point = frame_.ToGeodetic(p_m);
      double x_m = 0.0, y_m = 0.0, convergence_deg = 0.0, scale = 0.0;
      GeographicLib::TransverseMercator::UTM().Forward(
          central_meridian_deg_, point.lat_rad * kDegPerRad, point.lon_rad * kDegPerRad, x_m, y_m,
          convergence_deg, scale);
      const double c = std::cos(convergence_deg * kRadPerDeg);
      const double s = std::sin(convergence_deg * kRadPerDeg);
      Eigen::Matrix3d J_c_enu;
      J_c_enu << scale * c, -scale * s, 0.0, scale * s, scale * c, 0.0, 0.0, 0.0, 1.0;
      return J_c_enu * frame_.R_m_enu(p_m).transpose();
    }
    case Kind::kEcef:
      return frame_.R_me().transpose();
    case Kind::kProjected:
      return DifferenceQuotients(p_m);
    case Kind::kMap:
      break;
  }
  return Eigen::Matrix3d::Identity();
}

Eigen::Matrix3d PointCrs::DifferenceQuotients(const Eigen::Vector3d& p_m) const {
  constexpr double kStepM = 10.0;
  Eigen::Matrix3d J;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d step = kStepM * Eigen::Vector3d::Unit(k);
    J.col(k) = (MetricFromMap(p_m + step) - MetricFromMap(p_m - step)) / (2.0 * kStepM);
  }
  return J;
}

}  // namespace dn
