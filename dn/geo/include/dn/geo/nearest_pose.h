#pragma once

#include <dn/geo/trajectory.h>

#include <algorithm>
#include <vector>

namespace dn {

/// InterpolatePose; outside, the pose of the nearest end.
inline MapPose NearestPose(const std::vector<MapPose>& poses, double t_s) {
  return InterpolatePose(poses, std::clamp(t_s, poses.front().t_s, poses.back().t_s));
}

}  // namespace dn
