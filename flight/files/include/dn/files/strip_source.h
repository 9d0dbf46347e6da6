#pragma once

#include <dn/files/strip_files.h>
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

/// Points of a strip as the scanner measured them; each array has one element per point.
struct LaserVectors {
  std::vector<double> t_s;            ///< time on the scale of the trajectory
  std::vector<Eigen::Vector3d> u_s;   ///< laser vector in the sensor frame, m
  std::vector<std::uint16_t> source;  ///< LAS point source id; empty if the file has none
  std::vector<std::uint16_t> beam;    ///< number of the laser beam; empty if the file has none

  std::size_t size() const { return t_s.size(); }
};

/// The trajectory, mounting and filter for reading the strips of a flight.
struct StripSourceOptions {
  Trajectory trajectory;  ///< trajectory of the flight
  /// Trajectory from which the points of a file without laser vectors were computed; absent:
  /// `trajectory`.
  std::optional<Trajectory> made_by;
  StripGeoreferencing made_with;
  std::optional<Eigen::Vector2d> time_span_s;
  double time_offset_s = 0.0;  ///< offset of the time tags, tag = t + value
  PointFilter filter = {};
};

/// Numbers of points read from a strip.
struct StripCounts {
  std::uint64_t points = 0;
  std::uint64_t kept = 0;
  std::map<std::string, std::uint64_t> dropped;  ///< number of dropped points by reason
  std::optional<VectorOrigin> origin;            ///< of the laser vectors; absent for bare strips
  /// First and last time of the kept points, offset removed.
  double t_begin_s = 0.0, t_end_s = 0.0;
};

/// Reads the laser vectors of strips that belong to a trajectory. They are those of the file, or
/// else u = T^T Exp(-[theta']x) (R'_mb^T (p' - p'_mb) - a) of its points p'. The primed quantities
/// are the trajectory and the mounting from which the points were computed (FindVectorOrigin).
class StripSource {
 public:
  /// Throws InvalidInput for a trajectory without epochs, InvalidConfig for the name of a
  /// coordinate system that PointCrs does not support.
  StripSource(const StripSourceOptions& options, const LocalFrame& frame,
              const std::string& strips_crs);
  ~StripSource();

  /// Passes the points to `take` in chunks of at most 65536. Points without a pose are left out and
  /// counted. `take` may throw to stop the reading. Throws InvalidInput like OpenStrip, and for a
  /// file without points or GPS time. Also throws for coordinates outside the coordinate system,
  /// and if no point remains (with both spans).
  StripCounts Read(const std::filesystem::path& file,
                   const std::function<void(const LaserVectors&)>& take) const;

  /// Returns the pose of the trajectory, interpolated with InterpolatePose. Thread-safe.
  MapPose PoseAt(double t_s) const;

 private:
  struct Setup;
  std::unique_ptr<const Setup> setup_;
};

}  // namespace dn
