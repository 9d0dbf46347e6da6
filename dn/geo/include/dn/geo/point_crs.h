#pragma once

#include <dn/eigen_alignment.h>
#include <dn/geo/local_frame.h>

#include <Eigen/Core>
#include <string>

namespace dn {

/// Returns true if PointCrs accepts the name or it is "none": map, ecef, none, or utm:ZONEn,
/// utm:ZONEs (for example utm:32n).
bool IsPointCrsName(const std::string& name);

/// The coordinate system c of the points of a strip, on WGS84:
///
///   map         the mapping frame m
///   utm:32n     grid east, grid north (with the false origin 500 km, 0 or 10000 km), ellipsoidal
///               height
///   ecef        geocentric x, y, z
///
/// all in m. Copies share their data; every method is thread-safe.
class PointCrs {
 public:
  /// Creates the system. Throws InvalidConfig for any other name, including `none`.
  PointCrs(const std::string& name, const LocalFrame& frame);

  const std::string& name() const { return name_; }

  /// Converts a position in c to m, and back, in m. Accuracy about 5 nm. ToMap throws InvalidInput,
  /// naming the point and the bounds, for coordinates outside of the system.
  Eigen::Vector3d ToMap(const Eigen::Vector3d& p_c) const;
  Eigen::Vector3d FromMap(const Eigen::Vector3d& p_m) const;

  /// Returns d p_c / d p_m at a point: a rotation, multiplied for UTM by the scale of the grid.
  Eigen::Matrix3d J_c_m(const Eigen::Vector3d& p_m) const;

 private:
  enum class Kind { kMap, kUtm, kEcef };

  std::string name_;
  Kind kind_ = Kind::kMap;
  LocalFrame frame_;
  double central_meridian_deg_ = 0.0;
  double false_northing_m_ = 0.0;
};

}  // namespace dn
