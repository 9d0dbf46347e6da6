#pragma once

#include <dn/files/strip_files.h>
#include <dn/geo/accuracy_series.h>
#include <dn/geo/point_crs.h>
#include <dn/geo/trajectory.h>
#include <dn/lidar/beam_errors.h>
#include <dn/lidar/mounting.h>
#include <dn/lidar/strip_surface.h>
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

/// The errors that contribute to the covariance of a point (PointCovariance).
struct StripErrors {
  /// Sigmas of the trajectory over time; absent: the two below.
  std::optional<AccuracySeries> series;
  Eigen::Vector3d sigma_ned_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_rph_rad = Eigen::Vector3d::Zero();
  /// Covariance of the boresight, perturbed from the left.
  Eigen::Matrix3d boresight_rad2 = Eigen::Matrix3d::Zero();
  double sigma_range_m = 0.0;
  double sigma_beam_rad = 0.0;
};

struct GeoreferenceOptions {
  Trajectory trajectory;  ///< trajectory for the new points
  Mounting mounting;
  /// Trajectory from which the points of a file without laser vectors were computed; absent: the
  /// same trajectory.
  std::optional<Trajectory> made_by;
  StripGeoreferencing made_with;
  std::optional<Eigen::Vector2d> time_span_s;  ///< points outside are dropped
  /// Offset of the time tags, tag = t + value; the tags are not changed.
  double time_offset_s = 0.0;
  std::optional<StripErrors> errors;  ///< absent: no covariances
  /// Errors that are removed from the laser vectors; the files must then have vectors and beams.
  std::optional<BeamErrors> beams;
  /// Side of the cells of the surfaces, m; absent: no surfaces.
  std::optional<double> surface_cell_m;
  int threads = 1;
};

/// The result for the points of a strip.
struct GeoreferencedStrip {
  std::uint64_t points = 0;
  std::uint64_t kept = 0;
  std::map<std::string, std::uint64_t> dropped;  ///< number of dropped points by reason
  VectorOrigin origin;                           ///< origin of the laser vectors
  double t_begin_s = 0.0, t_end_s = 0.0;         ///< first and last time tag of all points
  double shift_rms_m = 0.0;  ///< shift of the remaining points by the new coordinates
  double shift_max_m = 0.0;
  /// A difference between the points of the file and the trajectory that no boresight explains
  /// (StripDisagreementText); empty: there is none.
  std::string disagreement;
  Swath swath;  ///< outline of the new points; the name is empty
  /// Flat ground of the points as they were and as they are now; empty without surface_cell_m.
  FlatSurface surface_before, surface_after;
};

/// Recomputes the coordinates of points:
///
///   p = p_mb + R_mb (Exp([theta]x) R_bs_nominal u + a)
///
/// with the laser vectors u of the file, without the errors of their beams. If the file has none,
///
///   u = R_bs_nominal^T Exp(-[theta']x) (R'_mb^T (p' - p'_mb) - a')
///
/// for its points p'. The primed quantities are the trajectory and the mounting from
/// which the points were computed (FindVectorOrigin). The new file records its boresight unless the
/// old one was only assumed. Poses are interpolated with InterpolatePose.
class StripGeoreferencer {
 public:
  StripGeoreferencer(GeoreferenceOptions options, const LocalFrame& frame, const PointCrs& crs);
  ~StripGeoreferencer();

  /// Reads a strip and writes it with new coordinates in the same format and coordinate system; all
  /// other content is kept. Points outside the trajectory, in its gaps or outside the time span are
  /// dropped and counted. `progress` is called with the number of points read after each chunk. It
  /// may throw to stop the work; then there is no output file. The memory does not grow with the
  /// file, except for the cells of the surfaces.
  ///
  /// Throws InvalidInput like OpenStrip, and for a file without points or GPS time. Also throws for
  /// coordinates outside the coordinate system, and if no point remains (with both spans). Throws
  /// InvalidInput if the points lie so far from the trajectory that they cannot belong to it.
  GeoreferencedStrip Run(const std::filesystem::path& in, const std::filesystem::path& out,
                         const std::function<void(std::uint64_t)>& progress) const;

 private:
  class Work;
  struct Setup;
  std::unique_ptr<const Setup> setup_;
};

}  // namespace dn
