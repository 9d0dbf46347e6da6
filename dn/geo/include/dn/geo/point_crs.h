#pragma once

#include <dn/eigen_alignment.h>
#include <dn/geo/local_frame.h>

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>

namespace dn {

namespace geo_internal {
class ProjectedCrs;
}  // namespace geo_internal

/// Lengths of the international foot and of the US survey foot.
inline constexpr double kFootM = 0.3048, kUsSurveyFootM = 1200.0 / 3937.0;

/// Returns true if PointCrs accepts names of this form or it is "none". A code need not exist.
bool IsPointCrsName(const std::string& name);

/// Returns the short name of a system: utm:32n for epsg:32632, and ecef for epsg:4978. Other names
/// stay as they are.
std::string ShortCrsName(const std::string& name);

/// Returns a name for people: of a system that is given as text (wkt:), the name in that text.
std::string ShownCrsName(const std::string& name);

/// Returns the horizontal part of a system as a .prj file states it, as well-known text in the form
/// of Esri. Returns nullopt for map and ecef, and for systems that have no such text.
std::optional<std::string> PrjText(const std::string& name);

/// Returns true if both names mean the same system.
bool IsSameCrs(const std::string& a, const std::string& b);

/// The name of a coordinate system that a file states.
struct NamedCrs {
  std::string name;         ///< as PointCrs takes it; empty if there is no such name
  std::optional<int> epsg;  ///< code of the horizontal or geocentric system
  /// The heights refer to a geoid, and the name does not say so: PROJ lacks the transformation.
  bool heights_from_geoid = false;
  std::string why_not;    ///< why it lacks it
  bool in_metres = true;  ///< false: coordinates or heights have another unit
};

/// Returns the name of the system of a code ("EPSG:2056", "EPSG:25832+7837") or of well-known
/// text. `height_unit_m` is the length of a unit of the heights if the file states it elsewhere.
NamedCrs NameCrs(const std::string& definition, std::optional<double> height_unit_m = {});

/// Returns metres per unit of the horizontal coordinates of a code or of well-known text; nullopt
/// for an unknown or geographic system.
std::optional<double> CrsUnitM(const std::string& definition);

/// Returns metres per unit of the three coordinates in a system that PointCrs takes.
Eigen::Vector3d CrsUnitsM(const std::string& name);

/// The coordinate system c of the points of a strip:
///
///   map            the mapping frame m
///   utm:32n        grid east, grid north (with the false origin 500 km, 0 or 10000 km),
///                  ellipsoidal height, on WGS84
///   ecef           geocentric x, y, z on WGS84
///   epsg:2056      any projected system of the EPSG register; epsg:25832+7837 with a vertical one.
///                  Without a vertical system, heights are ellipsoidal
///   wkt:TEXT       well-known text of a projected system
///
/// in m, and in the units of the system for epsg: and wkt:. The ending " heights:ft" or
/// " heights:us-ft" states another unit of the heights. Systems with the ellipsoid of WGS84 or
/// GRS80 count as systems on WGS84. Copies share their data; every method is thread-safe.
class PointCrs {
 public:
  /// Creates the system. Throws InvalidConfig for any other name, including `none`, and for a code
  /// that does not exist. Also throws if the transformation to WGS84 needs a grid that is missing.
  PointCrs(const std::string& name, const LocalFrame& frame);

  const std::string& name() const { return name_; }

  /// Converts a position in c to m, and back. Accuracy about 5 nm. ToMap throws InvalidInput,
  /// naming the point and the bounds, for coordinates outside of the system.
  Eigen::Vector3d ToMap(const Eigen::Vector3d& p_c) const;
  Eigen::Vector3d FromMap(const Eigen::Vector3d& p_m) const;

  /// Returns d p_c / d p_m at a point: a rotation, multiplied by the scale of the grid and by its
  /// units.
  Eigen::Matrix3d J_c_m(const Eigen::Vector3d& p_m) const;

 private:
  enum class Kind { kMap, kUtm, kEcef, kProjected };

  /// The same with heights in m.
  Eigen::Vector3d MetricToMap(const Eigen::Vector3d& p_c) const;
  Eigen::Vector3d MetricFromMap(const Eigen::Vector3d& p_m) const;
  Eigen::Matrix3d MetricJacobian(const Eigen::Vector3d& p_m) const;
  Eigen::Matrix3d DifferenceQuotients(const Eigen::Vector3d& p_m) const;

  std::string name_;
  Kind kind_ = Kind::kMap;
  LocalFrame frame_;
  double height_unit_m_ = 1.0;
  std::shared_ptr<const geo_internal::ProjectedCrs> projected_;
  double central_meridian_deg_ = 0.0;
  double false_northing_m_ = 0.0;
};

}  // namespace dn
