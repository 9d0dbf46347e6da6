#pragma once

#include <dn/flight/strip_files.h>
#include <dn/geo/local_frame.h>
#include <dn/geo/point_crs.h>
#include <dn/geo/trajectory.h>
#include <dn/lidar/point_filter.h>

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// Points of a strip as the scanner measured them, an element of each array per point.
struct LaserVectors {
  std::vector<double> t_s;            ///< epoch on the trajectory's scale
  std::vector<Eigen::Vector3d> u_s;   ///< laser vector in the sensor frame, m
  std::vector<std::uint16_t> source;  ///< LAS point source id; empty where the file has none

  std::size_t size() const { return t_s.size(); }
};

/// Where the points of a flight's strips come from.
struct StripSourceOptions {
  Trajectory trajectory;  ///< of the flight
  /// With which the points of a file without laser vectors were made; absent: `trajectory`.
  std::optional<Trajectory> made_by;
  StripGeoreferencing made_with;
  std::optional<Eigen::Vector2d> time_span_s;
  double time_offset_s = 0.0;  ///< of the points' tags, tag = t + value
  PointFilter filter = {};
};

/// What was read of a strip.
struct StripCounts {
  std::uint64_t points = 0;
  std::uint64_t kept = 0;
  std::map<std::string, std::uint64_t> dropped;  ///< by reason
  std::optional<VectorOrigin> origin;            ///< of the laser vectors; bare strips have none
  double t_begin_s = 0.0, t_end_s = 0.0;         ///< of the points kept, without the offset
};

/// Reads the laser vectors of strips that belong to a trajectory: those of the file, else
/// u = T^T Exp(-[theta']x) (R'_mb^T (p' - p'_mb) - a) of its points p', by the trajectory and the
/// mounting that they were made with (FindVectorOrigin).
class StripSource {
 public:
  /// Throws InvalidInput for a trajectory without epochs, InvalidConfig for a name of a coordinate
  /// system that PointCrs does not take.
  StripSource(const StripSourceOptions& options, const LocalFrame& frame,
              const std::string& strips_crs);
  ~StripSource();

  /// Gives `take` the points in chunks of at most 65536, those without a pose left out and
  /// counted. `take` may throw to end the reading. Throws InvalidInput as OpenStrip, for a file
  /// without points or GPS time, coordinates that are none of the system, and where no point is
  /// left, naming both spans.
  StripCounts Read(const std::filesystem::path& file,
                   const std::function<void(const LaserVectors&)>& take) const;

  /// Pose of the trajectory, as InterpolatePose gives it. Thread-safe.
  MapPose PoseAt(double t_s) const;

 private:
  struct Setup;
  std::unique_ptr<const Setup> setup_;
};

}  // namespace dn
