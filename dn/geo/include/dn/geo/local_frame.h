#pragma once

#include <dn/eigen_alignment.h>
#include <dn/error.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <numbers>

namespace dn {

/// Rotation rate of the Earth with respect to inertial space (WGS84), rad/s.
inline constexpr double kEarthRateRadps = 7.292115e-5;

/// Standard gravity, the unit g of data sheets and of "mg" and "ug", m/s^2.
inline constexpr double kStandardGravityMps2 = 9.80665;

inline constexpr double kRadPerDeg = std::numbers::pi / 180.0;
inline constexpr double kDegPerRad = 180.0 / std::numbers::pi;

/// A point given by geodetic latitude and longitude (rad) and ellipsoidal height (m) on WGS84.
struct Geodetic {
  double lat_rad = 0.0;
  double lon_rad = 0.0;
  double h_m = 0.0;
};

/// Returns the rotation from the local north-east-down frame of a point to ECEF; the height does
/// not matter.
Eigen::Matrix3d R_en(const Geodetic& point);

/// Converts a geodetic point to its ECEF position in m, and back (longitude in [-pi, pi]). Accuracy
/// about 1 nm.
Eigen::Vector3d ToEcef(const Geodetic& point);
Geodetic GeodeticFromEcef(const Eigen::Vector3d& p_e);

/// Throws InvalidInput, naming the coordinate and its bound, unless the point is finite, |lat| <=
/// pi/2 and -pi <= lon <= 2 pi.
void CheckGeodetic(const Geodetic& point, const FileLocation& where = {});

/// The mapping frame m of a project: the east-north-up tangent plane at an origin on WGS84, fixed
/// to the Earth. All states are expressed in it. Positions are metres from the origin; keep |p_m| <
/// 1e5 m for a resolution of 1e-11 m. Copies share their immutable data; every method is
/// thread-safe.
class LocalFrame {
 public:
  /// Creates the frame. Throws InvalidInput as CheckGeodetic does.
  explicit LocalFrame(const Geodetic& origin);

  const Geodetic& origin() const;

  /// Converts a geodetic point to its position in m, and back. Accuracy about 1 nm (GeographicLib).
  Eigen::Vector3d ToMap(const Geodetic& point) const;
  Geodetic ToGeodetic(const Eigen::Vector3d& p_m) const;

  /// Returns the rotation from the local north-east-down frame of the point p_m (not of the origin)
  /// to m.
  Eigen::Matrix3d R_mn(const Eigen::Vector3d& p_m) const;

  /// Returns the rotation from the local east-north-up frame of the point p_m to m.
  Eigen::Matrix3d R_m_enu(const Eigen::Vector3d& p_m) const;

  /// Returns the rotation ECEF -> m.
  const Eigen::Matrix3d& R_me() const;

  /// Returns the Earth rotation vector w_ie in m, rad/s; constant.
  const Eigen::Vector3d& w_ie_m() const;

  /// Returns the position of the frame's origin with respect to the centre of the Earth, in m axes,
  /// m.
  const Eigen::Vector3d& r0_m() const;

  /// Returns the gravitation (without the centrifugal term) of the WGS84 normal field at p_m, in m
  /// axes, m/s^2, for the equations in inertial form.
  Eigen::Vector3d Gravitation(const Eigen::Vector3d& p_m) const;

  /// Returns the normal gravity (gravitation plus centrifugal acceleration) at p_m, in m axes,
  /// m/s^2.
  Eigen::Vector3d Gravity(const Eigen::Vector3d& p_m) const;

 private:
  struct Data;
  std::shared_ptr<const Data> data_;
};

}  // namespace dn
