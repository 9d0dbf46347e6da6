#pragma once

#include <dn/geo/trajectory.h>

#include <algorithm>
#include <vector>

namespace dn {

/// Returns InterpolatePose at t_s; before or after all poses, the first or last pose.
inline MapPose NearestPose(const std::vector<MapPose>& poses, double t_s) {
  return InterpolatePose(poses, std::clamp(t_s, poses.front().t_s, poses.back().t_s));
}

}  // namespace dn
