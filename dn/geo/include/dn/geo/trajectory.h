#pragma once

#include <dn/geo/local_frame.h>
#include <dn/geo/trajectory_columns.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <filesystem>
#include <string>
#include <vector>

namespace dn {

/// One epoch of a navigation trajectory as it is exchanged. Body b is forward-right-down.
struct NavPoint {
  double t_s = 0.0;                                          ///< GPS seconds of week
  Geodetic position;                                         ///< of the body origin
  Eigen::Quaterniond q_nb = Eigen::Quaterniond::Identity();  ///< body -> local NED of the point
  Eigen::Vector3d v_ned_mps = Eigen::Vector3d::Zero();       ///< velocity north, east, down
  Eigen::Vector3d f_b_mps2 = Eigen::Vector3d::Zero();        ///< specific force in body
  Eigen::Vector3d w_b_radps = Eigen::Vector3d::Zero();       ///< angular rate in body
};

/// One epoch in the mapping frame.
struct MapPose {
  double t_s = 0.0;
  Eigen::Quaterniond q_mb = Eigen::Quaterniond::Identity();  ///< body -> map
  Eigen::Vector3d p_mb = Eigen::Vector3d::Zero();            ///< body origin in map, m
  Eigen::Vector3d v_m =
      Eigen::Vector3d::Zero();  ///< velocity with respect to the Earth in map, m/s
};

/// What a trajectory reader noticed and settled by itself.
struct TrajectoryNotes {
  long repeated_rows_dropped = 0;
  bool velocity_from_file =
      false;  ///< false: absent or contradicting the positions, hence differentiated
  /// SBET that was adjusted together with lidar pairs, as FormatSbet marks it.
  bool adjusted_with_lidar = false;
  std::string text;  ///< one line for the report; empty when there is nothing to say
};

/// A trajectory with strictly increasing times.
class Trajectory {
 public:
  Trajectory() = default;

  /// Throws InvalidInput when fewer than two points, times do not strictly increase, or a value is
  /// not finite.
  explicit Trajectory(std::vector<NavPoint> points, TrajectoryNotes notes = {});

  const std::vector<NavPoint>& points() const { return points_; }
  const TrajectoryNotes& notes() const { return notes_; }
  bool empty() const { return points_.empty(); }
  double t_begin_s() const { return points_.front().t_s; }
  double t_end_s() const { return points_.back().t_s; }
  bool Covers(double t_s) const { return !empty() && t_s >= t_begin_s() && t_s <= t_end_s(); }

  /// The first point at or after t_s, else the last.
  const NavPoint& PointFrom(double t_s) const;

  /// All points in the mapping frame.
  std::vector<MapPose> InMap(const LocalFrame& frame) const;
  /// InterpolatePose of them at t_s, where few times of many points are asked for.
  MapPose InMapAt(double t_s, const LocalFrame& frame) const;

 private:
  std::vector<NavPoint> points_;
  TrajectoryNotes notes_;
};

/// Pose at t_s by interpolation of a pose sequence: cubic Hermite in position (positions and
/// velocities), spherical linear in attitude. Throws InvalidInput when t_s is outside; poses sorted
/// by time.
MapPose InterpolatePose(const std::vector<MapPose>& poses, double t_s);

/// NavPoint of a MapPose (specific force and rate left zero), and back.
NavPoint ToNavPoint(const MapPose& pose, const LocalFrame& frame);
MapPose ToMapPose(const NavPoint& point, const LocalFrame& frame);

/// Reads SBET (17 float64, little endian) when the extension is .out or .sbet, else text of t and
/// the columns, by default those of ODyN: latitude, longitude [deg], height, quaternion w, x, y, z
/// body -> NED. SBET is what it is, whatever the columns.
///
/// SBET headings are made true by subtracting the wander angle. Its velocities are used where they
/// agree within 0.1 m/s with the positions under one of the sign conventions in use (y right or
/// left, z down or up, of the wander frame); otherwise, and for text, positions are differentiated.
/// The notes say which. Identical repeated rows are dropped and counted, a backward jump of a week
/// is continued.
///
/// Throws InvalidInput naming file and line or record: an incomplete last record, values that are
/// not finite or out of range, a quaternion whose norm is not 1 within 1 %, times that do not
/// increase. Throws InvalidConfig for a coordinate system that is none, or without its origin.
Trajectory ReadTrajectory(const std::filesystem::path& file, const TrajectoryColumns& columns = {});

/// Of an SBET file what a picture needs: times, positions and attitudes, of epochs at least
/// min_spacing_s apart. Throws as ReadTrajectory.
std::vector<NavPoint> ReadSbetPath(const std::filesystem::path& file, double min_spacing_s);

/// Serialised SBET: wander angle 0, velocities north, east, down, specific force and rate in body
/// (FRD). SBET has no header: where the trajectory was adjusted together with lidar pairs, the zero
/// of every wander angle is the negative one.
std::string FormatSbet(const std::vector<NavPoint>& points, bool adjusted_with_lidar = false);

/// Serialised ODyN text with 17 significant digits where needed.
std::string FormatTrajectoryText(const std::vector<NavPoint>& points);

}  // namespace dn
