#pragma once

#include <dn/flight/strip_files.h>
#include <dn/geo/accuracy_series.h>
#include <dn/geo/point_crs.h>
#include <dn/geo/trajectory.h>
#include <dn/lidar/mounting.h>
#include <dn/lidar/swath.h>

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

namespace dn {

/// What the covariance of a point is made of (PointCovariance).
struct StripErrors {
  std::optional<AccuracySeries> series;  ///< of the trajectory; absent: the two below
  Eigen::Vector3d sigma_ned_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_rph_rad = Eigen::Vector3d::Zero();
  Eigen::Matrix3d boresight_rad2 = Eigen::Matrix3d::Zero();  ///< left perturbation
  double sigma_range_m = 0.0;
  double sigma_beam_rad = 0.0;
};

struct GeoreferenceOptions {
  Trajectory trajectory;  ///< of the new points
  Mounting mounting;
  /// With which the points of a file without laser vectors were made; absent: the same trajectory.
  std::optional<Trajectory> made_by;
  StripGeoreferencing made_with;
  std::optional<Eigen::Vector2d> time_span_s;  ///< points outside are dropped
  double time_offset_s = 0.0;                  ///< of the points' tags, tag = t + value; they stay
  std::optional<StripErrors> errors;           ///< absent: no covariances
  int threads = 1;
};

/// What became of the points of a strip.
struct GeoreferencedStrip {
  std::uint64_t points = 0;
  std::uint64_t kept = 0;
  std::map<std::string, std::uint64_t> dropped;  ///< by reason
  VectorOrigin origin;                           ///< of the laser vectors
  double t_begin_s = 0.0, t_end_s = 0.0;         ///< of all points
  double shift_rms_m = 0.0;                      ///< by which the points that were kept moved
  double shift_max_m = 0.0;
  Swath swath;  ///< by the new coordinates; without the name
};

/// Computes points anew:
///
///   p = p_mb + R_mb (Exp([theta]x) T u + a)
///
/// with the laser vectors u of the file, else those that led to its points, u = T^T Exp(-[theta']x)
/// (R'_mb^T (p' - p'_mb) - a') by the trajectory and the mounting that they were made with
/// (FindVectorOrigin). The new file records its boresight unless the vectors are only assumed.
/// Poses are interpolated as InterpolatePose does.
class StripGeoreferencer {
 public:
  StripGeoreferencer(GeoreferenceOptions options, const LocalFrame& frame, const PointCrs& crs);
  ~StripGeoreferencer();

  /// Reads a strip and writes it with new coordinates, in the same format and coordinate system;
  /// all else of it is kept. Points outside the trajectory, in its gaps (FlightNeeds) or outside the
  /// time span are dropped and counted. `progress` is told the points that were read, after each
  /// chunk, and may throw to end the work: then no file appears. Memory does not grow with the file.
  ///
  /// Throws InvalidInput as OpenStrip, for a file without points or without GPS time, coordinates
  /// that are none of the system, and where no point is left, naming both spans.
  GeoreferencedStrip Run(const std::filesystem::path& in, const std::filesystem::path& out,
                         const std::function<void(std::uint64_t)>& progress) const;

 private:
  class Work;
  struct Setup;
  std::unique_ptr<const Setup> setup_;
};

}  // namespace dn
