#pragma once

#include <dn/eigen_alignment.h>
#include <dn/geo/local_frame.h>
#include <dn/geo/trajectory_columns.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <filesystem>
#include <string>
#include <vector>

namespace dn {

/// One epoch of a navigation trajectory. The body frame b is forward-right-down.
struct NavPoint {
  double t_s = 0.0;   ///< GPS seconds of week
  Geodetic position;  ///< position of the body origin
  /// Body -> local NED frame of the point.
  Eigen::Quaterniond q_nb = Eigen::Quaterniond::Identity();
  Eigen::Vector3d v_ned_mps = Eigen::Vector3d::Zero();  ///< velocity north, east, down
  Eigen::Vector3d f_b_mps2 = Eigen::Vector3d::Zero();   ///< specific force in body
  Eigen::Vector3d w_b_radps = Eigen::Vector3d::Zero();  ///< angular rate in body
};

/// One epoch in the mapping frame.
struct MapPose {
  double t_s = 0.0;
  Eigen::Quaterniond q_mb = Eigen::Quaterniond::Identity();  ///< body -> map
  Eigen::Vector3d p_mb = Eigen::Vector3d::Zero();            ///< body origin in map, m
  /// Velocity with respect to the Earth in map, m/s.
  Eigen::Vector3d v_m = Eigen::Vector3d::Zero();
};

/// Observations and decisions of a trajectory reader.
struct TrajectoryNotes {
  long repeated_rows_dropped = 0;
  /// False if velocities are absent or inconsistent with the positions, hence differentiated.
  bool velocity_from_file = false;
  /// True for an SBET that was adjusted together with lidar pairs, as marked by FormatSbet.
  bool adjusted_with_lidar = false;
  std::string text;  ///< one line for the report; may be empty
};

/// A trajectory with strictly increasing times.
class Trajectory {
 public:
  Trajectory() = default;

  /// Creates a trajectory. Throws InvalidInput if there are fewer than two points, times do not
  /// strictly increase, or a value is not finite.
  explicit Trajectory(std::vector<NavPoint> points, TrajectoryNotes notes = {});

  const std::vector<NavPoint>& points() const { return points_; }
  const TrajectoryNotes& notes() const { return notes_; }
  bool empty() const { return points_.empty(); }
  double t_begin_s() const { return points_.front().t_s; }
  double t_end_s() const { return points_.back().t_s; }
  bool Covers(double t_s) const { return !empty() && t_s >= t_begin_s() && t_s <= t_end_s(); }

  /// Returns the first point at or after t_s, or the last point.
  const NavPoint& FirstPointAtOrAfter(double t_s) const;

  /// Returns all points in the mapping frame.
  std::vector<MapPose> ToMapPoses(const LocalFrame& frame) const;
  /// Returns the pose that InterpolatePose gives at t_s, without converting all points; efficient
  /// for a few times.
  MapPose MapPoseAt(double t_s, const LocalFrame& frame) const;

 private:
  std::vector<NavPoint> points_;
  TrajectoryNotes notes_;
};

/// Interpolates poses, which must be sorted by time, at t_s: cubic Hermite in position (from
/// positions and velocities), spherical linear in attitude. Throws InvalidInput if t_s is outside
/// of their times.
MapPose InterpolatePose(const std::vector<MapPose>& poses, double t_s);

/// Converts a MapPose to a NavPoint (with zero specific force and rate), and back.
NavPoint ToNavPoint(const MapPose& pose, const LocalFrame& frame);
MapPose ToMapPose(const NavPoint& point, const LocalFrame& frame);

/// Reads SBET (17 float64, little endian) if the content is binary, otherwise text. A row of text
/// has t and the given columns. By default these are the columns of ODyN: latitude, longitude
/// [deg], height, quaternion w, x, y, z body -> NED. `columns` has no effect on SBET.
///
/// SBET headings are converted to true headings by subtracting the wander angle. The velocities of
/// an SBET are used if they agree with the positions within 0.1 m/s under one of the usual sign
/// conventions. These are y right or left, and z down or up, of the wander frame. Otherwise, and
/// for text, positions are differentiated; the notes say which. Identical repeated rows are dropped
/// and counted, and time is continued over week rollovers.
///
/// Throws InvalidInput, naming file and line or record, for an incomplete last record, and for
/// values that are not finite or out of range. Also throws for a quaternion whose norm differs from
/// 1 by more than 1 %, and for times that do not increase. Throws InvalidConfig for an unknown
/// coordinate system, or a map without its origin.
Trajectory ReadTrajectory(const std::filesystem::path& file, const TrajectoryColumns& columns = {});

/// Reads times, positions and attitudes of an SBET file, for a picture, at epochs at least
/// min_spacing_s apart. Throws as ReadTrajectory does.
std::vector<NavPoint> ReadSbetThinned(const std::filesystem::path& file, double min_spacing_s);

/// Returns the points as SBET: wander angle 0, velocities north, east, down, specific force and
/// rate in body (FRD). SBET has no header, so a trajectory that was adjusted together with lidar
/// pairs is marked by the sign: every wander angle is negative zero.
std::string FormatSbet(const std::vector<NavPoint>& points, bool adjusted_with_lidar = false);

/// Returns the points as ODyN text, with up to 17 significant digits.
std::string FormatTrajectoryText(const std::vector<NavPoint>& points);

}  // namespace dn
