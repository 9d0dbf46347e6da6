#pragma once

#include <dn/geo/trajectory.h>

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

PointFate FateBy(const CoveredTime& covered, double t_s);

/// Why nothing of a strip is left: `reason`, and both spans.
std::string NothingLeft(const std::string& reason, double t_begin_s, double t_end_s,
                        const CoveredTime& covered);

}  // namespace dn::internal
