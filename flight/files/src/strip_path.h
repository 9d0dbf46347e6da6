#pragma once

#include <dn/files/strip_agreement.h>
#include <dn/geo/trajectory.h>
#include <dn/lidar/strip_io.h>

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pair_coverage.h"

namespace dn::files_internal {

/// A trajectory in the map frame and the time that it covers.
struct StripPath {
  StripPath(const Trajectory& trajectory, const LocalFrame& frame)
      : poses(trajectory.ToMapPoses(frame)), covered(Cover(trajectory)) {}

  MapPose At(double t_s) const { return InterpolatePose(poses, AlignWeek(t_s, covered)); }

  /// Returns the pose, or nullopt outside of the trajectory.
  std::optional<MapPose> FindAt(double t_s) const;

  std::vector<MapPose> poses;
  CoveredTime covered;
};

/// Whether a point can be used, and otherwise the reason.
enum class PointFate { kKept, kBefore, kAfter, kInGap, kOutsideMaker, kOutsideSpan };

/// Returns the name of the reason in counts.
const char* FateReason(PointFate fate);

/// The trajectory for the new points, and the one from which the points of the file were computed.
class StripPaths {
 public:
  /// made_by: absent if it is the same trajectory. time_span_s: the time span of the requested
  /// points.
  StripPaths(const Trajectory& trajectory, const std::optional<Trajectory>& made_by,
             const std::optional<Eigen::Vector2d>& time_span_s, const LocalFrame& frame);

  const StripPath& wanted() const { return wanted_; }
  const StripPath& maker() const { return other_maker_ ? *other_maker_ : wanted_; }

  /// Returns whether a point can be used. own_vectors: the file has laser vectors, so that the
  /// trajectory of its coordinates is not needed.
  PointFate FindFate(double t_s, bool own_vectors) const;

 private:
  StripPath wanted_;
  std::optional<StripPath> other_maker_;
  CoveredTime span_;
};

/// Compares points of a strip with a trajectory (dn/files/strip_agreement.h).
std::optional<StripDisagreement> FindStripDisagreement(const std::vector<StripSample>& samples,
                                                       const StripPath& path,
                                                       const Mounting& mounting,
                                                       double largest_turn_rad);

/// Throws InvalidInput if the points of a file have no GPS time.
void ExpectTimes(const StripReader& reader, const std::filesystem::path& file);

/// Returns the message for a strip without remaining points: `reason` and both spans.
std::string NothingLeft(const std::string& reason, double t_begin_s, double t_end_s,
                        const CoveredTime& covered);

}  // namespace dn::files_internal
