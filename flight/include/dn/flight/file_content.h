#pragma once

#include <dn/geo/trajectory_columns.h>
#include <dn/gnss/gnss_data.h>
#include <dn/imu/imu_data.h>

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// What a data file may hold.
enum class FileKind { kUnknown, kImu, kGnss, kPairs, kTrajectory, kSmrmsg, kPointCloud };

/// What the first rows of a file show, whatever its name.
struct FileContent {
  std::filesystem::path file;
  FileKind kind = FileKind::kUnknown;
  std::string why;  ///< of a file of unknown kind: what keeps it from being read
  std::size_t columns = 0;
  ImuFormat imu_format = ImuFormat::kOdyn;
  bool rates_in_deg = false;  ///< of kImu: deg/s or deg, not rad/s or rad
  bool forces_in_g = false;   ///< of kImu: g, not m/s^2
  GnssFormat gnss_format = GnssFormat::kOdyn;
  bool has_sigma = false;     ///< of kGnss: of the positions
  bool has_velocity = false;  ///< of kGnss
  /// Of text of kTrajectory. The zone of a grid does not show: crs "utm:".
  std::optional<TrajectoryColumns> trajectory = {};
  /// Of text: known error of the tags, where they are seconds since 1980 or 1970 instead of GPS seconds
  /// of week: tag = t + value.
  double time_offset_s = 0.0;
};

/// Tells the kinds of files by their columns, sizes and steps:
///
///   kImu         7 columns (8 with an odometer): |columns 5-7| is gravity, in m/s^2 or g, or times
///                the step between the rows
///   kGnss        4, 7, 10 or 13 columns with latitude, longitude and positive sigmas; or a header of
///                RTKLIB, or sentences of NMEA
///   kPairs       8 or 14 columns that begin with two times
///   kTrajectory  8 columns that end with a unit quaternion, or 7 that end with three angles of which
///                the last follows the course; or records of an SBET
///   kPointCloud  the signature of LAS or LAZ
///   kSmrmsg      records of POSPac's smrmsg
///
/// Never throws for what a file holds.
FileContent LookAtFile(const std::filesystem::path& file);

/// What the entries of a folder hold, in order of their names. Folders, hidden files, YAML and JSON
/// are left out; what is no file that can be read, as a link that leads nowhere, is of unknown kind.
std::vector<FileContent> LookAtFolder(const std::filesystem::path& folder);

}  // namespace dn
