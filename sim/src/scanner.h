#pragma once

#include <dn/lidar/beam.h>
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

/// Sighting of a ground point: its epoch, the exact vector to the point in the sensor frame, and
/// the beam of a rotating scanner.
struct Sighting {
  double t_s = 0.0;
  Eigen::Vector3d u_s = Eigen::Vector3d::Zero();
  int beam = kNoBeam;
};

/// The true scanner on its true path. The beams of a line scanner lie in the plane through its
/// origin that is perpendicular to scan_axis. They are within half the field of view of nadir_axis.
/// The beams of a conical scanner lie at half the field of view around nadir_axis, so that each
/// point is passed twice, ahead and behind. Each beam of a rotating scanner lies on its own cone
/// about scan_axis. The effects lidar_scan_cone and lidar_scan_torsion
/// rotate the beams towards +scan_axis.
class Scanner {
 public:
  /// span: span of the epochs of the pairs, for effects that depend on it.
  Scanner(const LidarScenario& lidar, const ActiveEffects& effects, const LidarSpan& span,
          std::shared_ptr<const TruthTrajectory> truth, std::shared_ptr<const Terrain> terrain);

  /// Returns the sightings of the point between two poses of the true path, in time order. There is
  /// at most one for a line, and two for a cone. A sighting is omitted if the point is then outside
  /// the field of view or hidden by the surface. A rotating scanner needs the beam, which sees the
  /// point at most once.
  std::vector<Sighting> See(const Eigen::Vector3d& point_m, const MapPose& first,
                            const MapPose& last, int beam = kNoBeam) const;

  /// Returns the number of beams of a rotating scanner, 0 for the others.
  int num_beams() const { return lidar_.beams.count(); }

  /// Returns the true rotation from sensor to body, and the true origin of the sensor in body.
  Eigen::Matrix3d R_bs(double t_s) const;
  const Eigen::Vector3d& lever_arm_b_m() const { return mounting_.lever_arm_b_m; }

 private:
  /// Signed distance of a vector in the sensor frame from a surface that contains the beams.
  using FromBeams = std::function<double(const Eigen::Vector3d& u_s)>;

  // Returns the distance of a vector ahead of the beams of a line scanner, or of a beam of a
  // rotating scanner, m.
  double Ahead(const Eigen::Vector3d& u_s, int beam) const;
  // Returns the distance of a vector inside the cone of the beams, m.
  double InsideCone(const Eigen::Vector3d& u_s) const;
  /// Returns the vector from the scanner to a point, in the sensor frame, m.
  Eigen::Vector3d VectorTo(const Eigen::Vector3d& point_m, const MapPose& pose) const;
  /// Returns the pose at which the point lies on the beams.
  std::optional<MapPose> Swept(const FromBeams& from_beams, const Eigen::Vector3d& point_m,
                               const MapPose& first, const MapPose& last) const;
  // Returns all poses at which the point lies on the beams, in time order.
  std::vector<MapPose> AllSwept(const Eigen::Vector3d& point_m, const MapPose& first,
                                const MapPose& last, int beam) const;
  // Returns true if a vector lies in the field of view.
  bool InView(const Eigen::Vector3d& u_s) const;
  // Returns true if the surface hides the point from the scanner.
  bool Hidden(const Eigen::Vector3d& point_m, const MapPose& pose) const;

  std::shared_ptr<const TruthTrajectory> truth_;
  std::shared_ptr<const Terrain> terrain_;
  LidarScenario lidar_;
  Mounting mounting_;  // true mounting; its boresight is the one before effects
  const ActiveEffects& effects_;
  LidarSpan span_;
  Eigen::Matrix3d constant_R_bs_;  // valid if no effect changes the boresight
  Eigen::Vector3d scan_axis_s_;
  Eigen::Vector3d nadir_axis_s_;
  ScanPattern pattern_;
  double half_fov_rad_;
};

}  // namespace dn
