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

/// The kinds of data files.
enum class FileKind { kUnknown, kImu, kGnss, kPairs, kTrajectory, kSmrmsg, kPointCloud };

/// The content of a file, determined from its first rows and not from its name.
struct FileContent {
  std::filesystem::path file;
  FileKind kind = FileKind::kUnknown;
  std::string why;  ///< for kUnknown: why the file cannot be read
  std::size_t columns = 0;
  ImuFormat imu_format = ImuFormat::kOdyn;
  bool rates_in_deg = false;  ///< for kImu: rates in deg/s or angles in deg
  bool forces_in_g = false;   ///< for kImu: forces in g
  GnssFormat gnss_format = GnssFormat::kOdyn;
  bool has_sigma = false;     ///< for kGnss: the positions have sigmas
  bool has_velocity = false;  ///< for kGnss: the file has velocities
  /// For text of kTrajectory. The zone of a grid cannot be determined; its crs is "utm:".
  std::optional<TrajectoryColumns> trajectory = {};
  /// For text: offset of the time tags, tag = t + value. It is not 0 if the tags are seconds since
  /// 1980 or 1970 instead of GPS seconds of week.
  double time_offset_s = 0.0;
};

/// Determines the kind of a file from its number of columns and the size and step of its values:
///
///   kImu         7 columns (8 with an odometer): |columns 5-7| is gravity, in m/s^2 or g, or times
///                the step between the rows
///   kGnss        4, 7, 10 or 13 columns with latitude, longitude and positive sigmas; or a header
///                of RTKLIB, or sentences of NMEA
///   kPairs       8 or 14 columns that begin with two times
///   kTrajectory  8 columns that end with a unit quaternion, or 7 that end with three angles, the
///                last of them near the course; or records of an SBET
///   kPointCloud  the signature of LAS or LAZ
///   kSmrmsg      records of POSPac's smrmsg
///
/// Does not throw for any content of the file.
FileContent InspectFile(const std::filesystem::path& file);

/// Returns the content of the entries of a folder, sorted by name. Folders, hidden files, YAML and
/// JSON are left out. An entry that cannot be read, such as a dangling link, is of unknown kind.
std::vector<FileContent> InspectFolder(const std::filesystem::path& folder);

}  // namespace dn
