#pragma once

#include <dn/files/map_gnss.h>
#include <dn/geo/local_frame.h>
#include <dn/geo/trajectory.h>

#include <optional>
#include <vector>

namespace dn::apps {

/// Path of the body, for a first look at the points of strips.
struct RoughPath {
  LocalFrame frame{Geodetic{}};
  std::vector<MapPose> poses;
  bool from_course = false;  ///< level, with the course as heading; else of a trajectory

  /// Returns the pose at a time; nullopt outside of the poses and in gaps of more than 3 s.
  std::optional<MapPose> At(double t_s) const;
};

/// Returns a path whose heading is the course between GNSS positions, where the body moves.
RoughPath PathFromGnss(const MapGnss& gnss, const LocalFrame& frame);

}  // namespace dn::apps
