#pragma once

#include <dn/sim/scenario.h>
#include <dn/sim/terrain.h>
#include <dn/sim/truth.h>

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "active_effects.h"

namespace dn {

/// A ground point seen by the scanner: when, and the exact vector to it in the sensor frame.
struct Sighting {
  double t_s = 0.0;
  Eigen::Vector3d u_s = Eigen::Vector3d::Zero();
};

/// The true scanner on its true path. The beams of a line scanner lie in the plane through its origin
/// that is perpendicular to scan_axis, within half the field of view of nadir_axis; those of a conical
/// one at half the field of view from nadir_axis all around, so that a point is passed twice, ahead
/// and behind. The effect lidar_scan_cone turns all of them toward +scan_axis.
class Scanner {
 public:
  /// span: of the epochs that the pairs will have, for effects that refer to them.
  Scanner(const LidarScenario& lidar, const ActiveEffects& effects, const LidarSpan& span,
          std::shared_ptr<const TruthTrajectory> truth, std::shared_ptr<const Terrain> terrain);

  /// When, between two poses of the true path, the beams sweep over the point, in the order of time:
  /// at most once for a line, twice for a cone. Not where the point is outside the field of view
  /// then, or hidden behind the surface.
  std::vector<Sighting> See(const Eigen::Vector3d& point_m, const MapPose& first,
                            const MapPose& last) const;

  /// True rotation sensor -> body, and the true origin of the sensor in body.
  Eigen::Matrix3d R_bs(double t_s) const;
  const Eigen::Vector3d& lever_arm_b_m() const { return mounting_.lever_arm_b_m; }

 private:
  /// Signed distance of a vector in the sensor frame from a surface on which the beams lie.
  using FromBeams = double (Scanner::*)(const Eigen::Vector3d& u_s) const;

  double Ahead(const Eigen::Vector3d& u_s) const;
  double InsideCone(const Eigen::Vector3d& u_s) const;
  /// Vector from the scanner to a point, in the sensor frame, m.
  Eigen::Vector3d VectorTo(const Eigen::Vector3d& point_m, const MapPose& pose) const;
  /// The pose at which the point lies on the beams.
  std::optional<MapPose> Swept(FromBeams from_beams, const Eigen::Vector3d& point_m,
                               const MapPose& first, const MapPose& last) const;
  std::vector<MapPose> AllSwept(const Eigen::Vector3d& point_m, const MapPose& first,
                                const MapPose& last) const;
  bool InView(const Eigen::Vector3d& u_s) const;
  bool Hidden(const Eigen::Vector3d& point_m, const MapPose& pose) const;

  std::shared_ptr<const TruthTrajectory> truth_;
  std::shared_ptr<const Terrain> terrain_;
  Mounting mounting_;  // true; the boresight is that before effects
  const ActiveEffects& effects_;
  LidarSpan span_;
  Eigen::Matrix3d constant_R_bs_;  // where no effect changes the boresight
  Eigen::Vector3d scan_axis_s_;
  Eigen::Vector3d nadir_axis_s_;
  double sine_of_turn_;  // of the beams toward +scan_axis
  ScanPattern pattern_;
  double half_fov_rad_;
};

}  // namespace dn
