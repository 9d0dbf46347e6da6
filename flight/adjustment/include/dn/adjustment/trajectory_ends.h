#pragma once

#include <dn/adjustment/pose_interpolator.h>
#include <dn/files/flight.h>
#include <dn/fixed_trajectory/gauss_helmert.h>

#include <Eigen/Core>

namespace dn {

/// Statistics of the angle between cubic and linear interpolation of the attitude.
struct InterpolationDeviation {
  double max_rad = 0.0, sum2_rad2 = 0.0, n = 0.0;

  void Add(double angle_rad);
  void operator+=(const InterpolationDeviation& other);
};

/// Poses and laser vectors of a flight's scanner on the given trajectory. The poses are
/// interpolated by PoseInterpolator (linearly with gh.libor_compat, as in libor); the sigmas are
/// those of the section `trajectory`.
class TrajectoryEnds {
 public:
  /// Throws InvalidInput without a trajectory or the sections `lidar` and `trajectory`. The flight
  /// must outlive the object.
  explicit TrajectoryEnds(const Flight& flight);

  /// Returns the end of a pair at t_s. `u_s` is the laser vector in the sensor frame, m. If
  /// `deviation` is not null, adds the angle between both interpolations. Thread-safe for different
  /// `deviation`. Throws InvalidInput with the time if t_s is outside of the trajectory.
  GaussHelmertEnd At(double t_s, const Eigen::Vector3d& u_s,
                     InterpolationDeviation* deviation = nullptr) const;

 private:
  const Flight& flight_;
  PoseInterpolator poses_;
};

}  // namespace dn
