#pragma once

#include <dn/geo/trajectory.h>
#include <dn/lidar/strip_io.h>

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pair_coverage.h"

namespace dn::internal {

/// A trajectory in the mapping frame, and the time that it covers.
struct StripPath {
  StripPath(const Trajectory& trajectory, const LocalFrame& frame)
      : poses(trajectory.InMap(frame)), covered(Cover(trajectory)) {}

  MapPose At(double t_s) const { return InterpolatePose(poses, AlignWeek(t_s, covered)); }

  std::vector<MapPose> poses;
  CoveredTime covered;
};

/// What a trajectory means for a point.
enum class PointFate { kKept, kBefore, kAfter, kInGap, kOutsideMaker, kOutsideSpan };

/// Why a point is left out, as counts name it.
const char* ReasonOf(PointFate fate);

/// The trajectory that points are wanted on, and the one that they were made with.
class StripPaths {
 public:
  /// made_by: absent, the same trajectory. time_span_s: of the points that are wanted.
  StripPaths(const Trajectory& trajectory, const std::optional<Trajectory>& made_by,
             const std::optional<Eigen::Vector2d>& time_span_s, const LocalFrame& frame);

  const StripPath& wanted() const { return wanted_; }
  const StripPath& maker() const { return other_maker_ ? *other_maker_ : wanted_; }

  /// own_vectors: the file has laser vectors, so what made its points does not count.
  PointFate FateOf(double t_s, bool own_vectors) const;

 private:
  StripPath wanted_;
  std::optional<StripPath> other_maker_;
  CoveredTime span_;
};

/// Throws InvalidInput where the points of a file have no GPS time.
void ExpectTimes(const StripReader& reader, const std::filesystem::path& file);

/// Why nothing of a strip is left: `reason`, and both spans.
std::string NothingLeft(const std::string& reason, double t_begin_s, double t_end_s,
                        const CoveredTime& covered);

}  // namespace dn::internal
