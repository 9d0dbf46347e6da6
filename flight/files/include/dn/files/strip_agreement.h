#pragma once

#include <dn/geo/trajectory.h>
#include <dn/lidar/mounting.h>

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// A point of a strip.
struct StripSample {
  double t_s = 0.0;                               ///< time tag on the scale of the trajectory
  Eigen::Vector3d p_m = Eigen::Vector3d::Zero();  ///< its coordinates in the file, in map
  std::optional<Eigen::Vector3d> u_s;             ///< its laser vector, if the file has them
};

/// Keeps a number of points of a strip of any length, evenly chosen.
class StripSampler {
 public:
  /// Returns whether the next point belongs to the sample; Add must then follow.
  bool Wants() { return seen_++ % step_ == 0; }
  void Add(StripSample sample);
  const std::vector<StripSample>& samples() const { return samples_; }

 private:
  std::size_t seen_ = 0, step_ = 1;
  std::vector<StripSample> samples_;
};

/// A difference between the points of a strip and a trajectory that no boresight explains.
struct StripDisagreement {
  enum class Kind {
    kClock,   ///< the points agree with other time tags
    kFeet,    ///< heights in feet
    kShift,   ///< a shift of another cause: another height system, datum or trajectory
    kAbove,   ///< the points lie above the trajectory
    kOutside  ///< the points have tags outside of the trajectory, and no other clock explains them
  };
  Kind kind = Kind::kShift;
  double offset_s = 0.0;  ///< for kClock: tag = t + offset
  double sigma_s = 0.0;   ///< uncertainty of offset_s
  /// For kOutside: first and last tag of the points, and times of the trajectory.
  double t_first_s = 0.0, t_last_s = 0.0, t_begin_s = 0.0, t_end_s = 0.0;
  /// Mean shift of the points of the file: along and across the course (right), and up. For points
  /// without laser vectors it is that from below the trajectory.
  Eigen::Vector3d apart_m = Eigen::Vector3d::Zero();
  double limit_m = 0.0;  ///< largest shift that a boresight explains
  double range_m = 0.0;  ///< median length of the laser vectors, or height above the points

  /// Returns whether no work with the points makes sense: heights in feet or above the trajectory,
  /// or a clock that shifts the points by more than any mounting does.
  bool Forbids() const;
};

/// Returns the pose at a time; nullopt outside the trajectory.
using PoseAt = std::function<std::optional<MapPose>(double t_s)>;

/// Compares points of a strip with the trajectory between two times. With laser vectors, the points
/// must lie where the trajectory and the mounting put them, except for a turn of the mounting by
/// up to largest_turn_rad. Without, they must lie below the trajectory; the plane in which a
/// scanner looks then shows the clock by the motion of the body. Returns nullopt if they agree, and
/// for too few points.
std::optional<StripDisagreement> FindStripDisagreement(const std::vector<StripSample>& samples,
                                                       const PoseAt& pose_at, double t_begin_s,
                                                       double t_end_s, const Mounting& mounting,
                                                       double largest_turn_rad);

/// Returns the largest turn that the change from one boresight to another explains, with a margin.
double LargestTurn(const Eigen::Vector3d& before_rad, const Eigen::Vector3d& after_rad);

/// Describes the disagreement and its remedy. declared_s: lidar.time_offset_s of flight.yaml.
std::string StripDisagreementText(const StripDisagreement& found, double declared_s);

}  // namespace dn
