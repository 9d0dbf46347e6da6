#pragma once

#include <dn/sim/scenario.h>
#include <dn/sim/terrain.h>
#include <dn/sim/truth.h>

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>

#include "active_effects.h"

namespace dn {

/// A ground point seen by the scanner: when, and the exact vector to it in the sensor frame.
struct Sighting {
  double t_s = 0.0;
  Eigen::Vector3d u_s = Eigen::Vector3d::Zero();
};

/// The true scanner on its true path, within half the field of view of nadir_axis: a line scanner,
/// whose beams lie in the plane through its origin that is perpendicular to scan_axis, or, with a
/// cone, leave this plane by its angle toward +scan_axis.
class Scanner {
 public:
  /// span: of the epochs that the pairs will have, for effects that refer to them.
  Scanner(const LidarScenario& lidar, const ActiveEffects& effects, const LidarSpan& span,
          std::shared_ptr<const TruthTrajectory> truth, std::shared_ptr<const Terrain> terrain);

  /// When, in [t0_s, t1_s], the beams sweep over the point; nothing when they do not, when the
  /// point is outside the field of view then, or hidden behind the surface.
  std::optional<Sighting> See(const Eigen::Vector3d& point_m, double t0_s, double t1_s) const;

  /// Vector from the scanner to a point, in the sensor frame, m.
  Eigen::Vector3d VectorTo(const Eigen::Vector3d& point_m, double t_s) const;

 private:
  Eigen::Matrix3d R_bs(double t_s) const;
  double Ahead(const Eigen::Vector3d& point_m, double t_s) const;
  std::optional<double> SweepTime(const Eigen::Vector3d& point_m, double t0_s, double t1_s) const;
  bool Hidden(const Eigen::Vector3d& point_m, double t_s) const;

  std::shared_ptr<const TruthTrajectory> truth_;
  std::shared_ptr<const Terrain> terrain_;
  Mounting mounting_;  // true; the boresight is that before effects
  const ActiveEffects& effects_;
  LidarSpan span_;
  Eigen::Matrix3d constant_R_bs_;  // where no effect changes the boresight
  Eigen::Vector3d scan_axis_s_;
  Eigen::Vector3d nadir_axis_s_;
  double sine_of_cone_;
  double half_fov_rad_;
};

}  // namespace dn
