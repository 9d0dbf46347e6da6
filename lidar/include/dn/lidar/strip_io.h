#pragma once

#include <dn/lidar/strip_cloud.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

namespace dn {

/// What a file says of the coordinate system of its points.
struct StripCrs {
  std::optional<int> epsg;  ///< of the horizontal, or three-dimensional, system
  std::string text;         ///< its name or well-known text; empty: nothing is said
  std::string name;         ///< as strips_crs of flight.yaml calls it: utm:32n, ecef; else empty
  bool heights_from_geoid = false;  ///< a vertical system is named: heights are not ellipsoidal
};

/// Writes points to a file that appears complete or not at all.
class StripWriter {
 public:
  virtual ~StripWriter() = default;

  /// Points of the reader that this writer was made by, changed or fewer; of a new file, any.
  /// Throws InvalidInput, naming the point, when one cannot be represented; std::filesystem::filesystem_error when the
  /// file cannot be written.
  virtual void Append(const StripCloud& points) = 0;

  /// Completes the file and gives it its name. Last call.
  virtual void Finish() = 0;
};

/// Content that a rewritten strip gets.
struct StripAdditions {
  /// Every point gets columns (text) or extra bytes (LAS) for its covariance_c_m2.
  bool covariance = false;
  /// Boresight that the new points were computed with (FRD, rad): a record of a LAS file, in place
  /// of an older one. Text has no place for it, and always has laser vectors.
  std::optional<Eigen::Vector3d> boresight_rad = {};
};

/// Reads the points of a strip in chunks of at most 65536: memory does not grow with the file.
class StripReader {
 public:
  virtual ~StripReader() = default;

  /// The next points in place of what `chunk` holds; false after the last. Throws InvalidInput
  /// naming the file and the record or line.
  virtual bool Next(StripCloud* chunk) = 0;

  virtual bool has_time() const = 0;
  virtual bool has_vectors() const = 0;  ///< laser vectors
  virtual const StripCrs& crs() const = 0;
  /// Boresight that the points were computed with, where the file records it (MakeWriter): rotation
  /// vector about the body axes (FRD), rad.
  virtual std::optional<Eigen::Vector3d> boresight_rad() const { return std::nullopt; }
  /// Points of the file, where its header says so.
  virtual std::optional<std::uint64_t> points() const = 0;

  /// A writer of a file of the same format, version, coordinate system and further content.
  virtual std::unique_ptr<StripWriter> MakeWriter(const std::filesystem::path& file,
                                                  const StripAdditions& additions) const = 0;
};

/// Opens a strip by the end of its name:
///
///   .las    ASPRS LAS 1.2 to 1.4, point formats 0 to 10, with extra bytes. GPS time of both kinds
///           ("adjusted standard" is converted to seconds of week, counted from the begin of the
///           week of the first point). Laser vectors are extra bytes named ux, uy, uz [m]. The
///           coordinate system is read from GeoTIFF keys and well-known text.
///   .txt    LiMatch text: t, x, y, z, ux, uy, uz, optionally the covariance of x, y, z in m^2
///           (upper triangle xx, xy, xz, yy, yz, zz)
///
/// Throws InvalidInput, naming the file and what to do, for LAZ, another ending, a header that
/// contradicts itself, its records or the size of the file, coordinates that are not in metres, a
/// time that is no second of week, a laser vector that is shorter than 1 mm or longer than 50 km.
std::unique_ptr<StripReader> OpenStrip(const std::filesystem::path& file);

/// The grid of a new LAS file: coordinates are offset_m plus a multiple of scale_m, within 2^31 of
/// them.
struct LasGrid {
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();
  double scale_m = 1e-4;
};

/// Writes a LAS file that has no predecessor: version 1.4, point format 6 (64-bit counts, and extra
/// bytes belong to the specification), GPS time in seconds of week, the laser vector as extra bytes
/// ux, uy, uz [m] of doubles, each point the only return of its pulse. The coordinate system is not
/// named. Append needs p_c, t_s and u_s; source and intensity are 0 where they are empty.
std::unique_ptr<StripWriter> NewLasStrip(const std::filesystem::path& file, const LasGrid& grid);

}  // namespace dn
