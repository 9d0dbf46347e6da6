#pragma once

#include <dn/calibration/pose_interpolator.h>
#include <dn/flight/flight.h>
#include <dn/solvers/gauss_helmert.h>

#include <Eigen/Core>

namespace dn {

/// How far cubic and linear interpolation of the attitude are apart.
struct InterpolationDeviation {
  double max_rad = 0.0, sum2_rad2 = 0.0, n = 0.0;

  void Add(double angle_rad);
  void operator+=(const InterpolationDeviation& other);
};

/// What the scanner of a flight sees from its trajectory: poses interpolated (PoseInterpolator; with
/// gh.libor_compat linearly, as libor does), sigmas of the section `trajectory`.
class TrajectoryEnds {
 public:
  /// Throws InvalidInput without a trajectory or the sections `lidar` and `trajectory`.
  explicit TrajectoryEnds(const Flight& flight);

  /// u_s: laser vector in the sensor frame, m. Thread-safe. Throws InvalidInput naming the time when
  /// t_s is outside of the trajectory.
  GaussHelmertEnd At(double t_s, const Eigen::Vector3d& u_s,
                     InterpolationDeviation* deviation = nullptr) const;

 private:
  const Flight& flight_;
  PoseInterpolator poses_;
};

}  // namespace dn
