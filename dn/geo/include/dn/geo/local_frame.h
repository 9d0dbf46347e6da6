#pragma once

#include <dn/error.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <numbers>

namespace dn {

/// Rotation rate of the Earth with respect to inertial space (WGS84), rad/s.
inline constexpr double kEarthRateRadps = 7.292115e-5;

/// The g of data sheets and of every "mg" and "ug", m/s^2.
inline constexpr double kStandardGravityMps2 = 9.80665;

inline constexpr double kRadPerDeg = std::numbers::pi / 180.0;
inline constexpr double kDegPerRad = 180.0 / std::numbers::pi;

/// A point by geodetic latitude and longitude (rad) and ellipsoidal height (m) on WGS84.
struct Geodetic {
  double lat_rad = 0.0;
  double lon_rad = 0.0;
  double h_m = 0.0;
};

/// Rotation from the local north-east-down of a point to ECEF; the height has no influence.
Eigen::Matrix3d R_en(const Geodetic& point);

/// ECEF position in m of a geodetic point, and back (longitude in [-pi, pi]). Accuracy about 1 nm.
Eigen::Vector3d ToEcef(const Geodetic& point);
Geodetic GeodeticFromEcef(const Eigen::Vector3d& p_e);

/// Throws InvalidInput, saying which of the three and its bound, unless the point is finite, |lat|
/// <= pi/2 and -pi <= lon <= 2 pi.
void CheckGeodetic(const Geodetic& point, const FileLocation& where = {});

/// The mapping frame m of a project: the east-north-up tangent plane at an origin on WGS84, rigidly
/// fixed to the Earth. All states live in it; positions are metres from the origin, so keep |p_m| <
/// 1e5 m for 1e-11 m resolution. Copies share their (immutable) data; every method is thread-safe.
class LocalFrame {
 public:
  /// Throws InvalidInput as CheckGeodetic.
  explicit LocalFrame(const Geodetic& origin);

  const Geodetic& origin() const;

  /// Position in m of a geodetic point, and back. Accuracy about 1 nm (GeographicLib).
  Eigen::Vector3d ToMap(const Geodetic& point) const;
  Geodetic ToGeodetic(const Eigen::Vector3d& p_m) const;

  /// Rotation from the local north-east-down of the point p_m (not of the origin) to m.
  Eigen::Matrix3d R_mn(const Eigen::Vector3d& p_m) const;

  /// Rotation from the local east-north-up of the point p_m to m.
  Eigen::Matrix3d R_m_enu(const Eigen::Vector3d& p_m) const;

  /// Rotation ECEF -> m.
  const Eigen::Matrix3d& R_me() const;

  /// Earth rotation vector w_ie in m, rad/s; constant.
  const Eigen::Vector3d& w_ie_m() const;

  /// Position of the frame's origin with respect to the centre of the Earth, in m axes, m.
  const Eigen::Vector3d& r0_m() const;

  /// Gravitational attraction (without the centrifugal term) of the WGS84 normal field at p_m, in m
  /// axes, m/s^2. For the inertial-form equations.
  Eigen::Vector3d Attraction(const Eigen::Vector3d& p_m) const;

  /// Normal gravity (attraction plus centrifugal) at p_m, in m axes, m/s^2.
  Eigen::Vector3d Gravity(const Eigen::Vector3d& p_m) const;

 private:
  struct Data;
  std::shared_ptr<const Data> data_;
};

}  // namespace dn
