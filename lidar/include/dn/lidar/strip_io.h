#pragma once

#include <dn/lidar/strip_cloud.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

namespace dn {

/// Coordinate system of the points of a strip according to its file.
struct StripCrs {
  std::optional<int> epsg;  ///< EPSG code of the horizontal or three-dimensional system
  std::string
      text;  ///< name or well-known text of the system; empty: the file does not state a system
  /// Name in strips_crs of flight.yaml: utm:32n, ecef, epsg:2056, wkt:TEXT; empty if PROJ does not
  /// know the system.
  std::string name;
  /// The heights refer to a geoid, and `name` does not contain the transformation.
  bool heights_from_geoid = false;
  std::string why_not = {};  ///< why it does not
  bool in_metres = true;     ///< false: coordinates or heights have another unit, as `name` says
};

/// Writes points to a file. The file appears under its name only when it is complete.
class StripWriter {
 public:
  virtual ~StripWriter() = default;

  /// Appends points. A writer that a reader has made accepts only points of that reader, possibly
  /// changed or reduced. A writer of a new file accepts any points. Throws InvalidInput with the
  /// point if a coordinate cannot be represented. Throws std::filesystem::filesystem_error if the
  /// file cannot be written.
  virtual void Append(const StripCloud& points) = 0;

  /// Completes the file and renames it to its final name. This must be the last call.
  virtual void Finish() = 0;
};

/// Contents that are added to a rewritten strip.
struct StripAdditions {
  /// Adds the covariance_c_m2 of every point as columns (text) or extra bytes (LAS).
  bool covariance = false;
  /// Boresight with which the new points were computed (FRD, rad). A LAS file records it, in place
  /// of an earlier record. A text file cannot, and always has laser vectors.
  std::optional<Eigen::Vector3d> boresight_rad = {};
};

/// Reads the points of a strip in chunks of at most 65536, so that memory does not grow with the
/// file.
class StripReader {
 public:
  virtual ~StripReader() = default;

  /// Replaces the contents of `chunk` by the next points; returns false after the last point.
  /// Throws InvalidInput with the file and the record or line.
  virtual bool Next(StripCloud* chunk) = 0;

  virtual bool has_time() const = 0;
  virtual bool has_vectors() const = 0;  ///< true if the points have laser vectors
  virtual const StripCrs& crs() const = 0;
  /// Boresight with which the points were computed, if the file records it (MakeWriter): rotation
  /// vector about the body axes (FRD), rad.
  virtual std::optional<Eigen::Vector3d> boresight_rad() const { return std::nullopt; }
  /// Number of points according to the header of the file; nullopt if the header does not contain
  /// it.
  virtual std::optional<std::uint64_t> points() const = 0;

  /// Returns a writer for a file with the same format, version, coordinate system and other
  /// contents. LAS points are compressed if the name ends in .laz.
  virtual std::unique_ptr<StripWriter> MakeWriter(const std::filesystem::path& file,
                                                  const StripAdditions& additions) const = 0;
};

/// Opens a strip. The content selects the format:
///
///   LAS     ASPRS LAS 1.0 to 1.4, point formats 0 to 10, with extra bytes; compressed or not (LAZ,
///           COPC). "Adjusted standard" GPS time is converted to seconds of the week of the first
///           point. Laser vectors are extra bytes named ux, uy, uz [m], and the number of the
///           laser beam is one named beam. The coordinate system is read from GeoTIFF keys and
///           well-known text.
///   text    LiMatch text: t, x, y, z, ux, uy, uz, optionally the covariance of x, y, z in m^2
///           (upper triangle xx, xy, xz, yy, yz, zz), optionally the number of the laser beam
///
/// Throws InvalidInput, with the file and the remedy, for any other binary file. Also throws it for
/// a header that contradicts itself, its records or the file size, and for damaged points. The
/// units must be metres, a time must be a second of week, and a laser vector between 1 mm and 50 km
/// long. The message names the record or the byte.
std::unique_ptr<StripReader> OpenStrip(const std::filesystem::path& file);

/// Coordinate grid of a new LAS file. Each coordinate is offset_m plus an integer multiple of
/// scale_m, where the integer has a magnitude below 2^31.
struct LasGrid {
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();
  double scale_m = 1e-4;
};

/// Creates a new LAS or LAZ file: version 1.4, point format 6, time in seconds of week. This format
/// has 64-bit counts, and its specification includes extra bytes. The laser vector is stored as
/// extra bytes ux, uy, uz [m] of type double. With `with_beam`, the beam is an extra attribute of
/// type unsigned short. The file does not name a coordinate system. Append needs p_c, t_s and u_s,
/// and beam if it is written. Empty arrays of source, intensity, classification and flags are
/// written as 0. Without return_number and returns_after, each point is the only return of its
/// pulse.
std::unique_ptr<StripWriter> NewLasStrip(const std::filesystem::path& file, const LasGrid& grid,
                                         bool with_beam = false);

}  // namespace dn
