#pragma once

#include <dn/geo/named_columns.h>
#include <dn/geo/trajectory_columns.h>
#include <dn/gnss/gnss_data.h>
#include <dn/imu/imu_data.h>

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
  /// For kUnknown: why the file is not used. For other kinds: what is unusual about the columns.
  std::string why;
  /// For text: names of the columns for flight.yaml; empty for the columns of a documented format.
  ColumnNames columns;
  ImuFormat imu_format = ImuFormat::kOdyn;
  bool rates_in_deg = false;  ///< for kImu: rates in deg/s or angles in deg
  bool forces_in_g = false;   ///< for kImu: forces in g
  /// For kImu in counts or other units: rad/s (rad) and m/s^2 (m/s) of one unit, else 0.
  double rate_unit = 0.0, force_unit = 0.0;
  GnssFormat gnss_format = GnssFormat::kOdyn;
  bool has_sigma = false;     ///< for kGnss: the positions have sigmas
  bool has_velocity = false;  ///< for kGnss: the file has velocities
  /// For kGnss: names of columns with an accuracy that `columns` cannot express, in quotes.
  std::string accuracy;
  std::string crs;            ///< for kGnss: the coordinate system, if it is not geographic
  bool only_changed = false;  ///< for kGnss: `rows: changed` of flight.yaml
  /// For kGnss in geographic coordinates: columns of a trajectory with the same positions, if the
  /// header names roll, pitch and heading.
  ColumnNames attitude;
  /// For text of kTrajectory. The zone of a grid cannot be determined; its crs is "utm:".
  std::optional<TrajectoryColumns> trajectory = {};
  /// For text: offset of the time tags, tag = t + value. It is not 0 if the tags are seconds since
  /// 1980 or 1970 instead of GPS seconds of week.
  double time_offset_s = 0.0;
};

/// Determines the kind of a file by its content. A text is tested against each kind, by the names
/// of a header or by trial of the columns. The tests are time that increases in plausible steps,
/// gravity and rates, coordinates and speed, sigmas, quaternions and course. The kind with all
/// tests passed is taken. Otherwise `why` names the nearest kind and what it lacks, then the second
/// nearest.
///
///   kImu         rates and forces; |force| is gravity, in m/s^2 or g, or times the step. A header
///                that names rates and accelerations decides
///   kGnss        latitude, longitude, height, perhaps sigmas and velocities; or a solution of
///                RTKLIB, or sentences of NMEA
///   kPairs       8, 10, 14 or 16 columns that begin with two times
///   kTrajectory  a position with a unit quaternion, or with three angles, the last of them near
///                the course; or records of an SBET
///   kPointCloud  the signature of LAS or LAZ
///   kSmrmsg      records of POSPac's smrmsg
///
/// Does not throw for any content of the file. A log with several kinds of messages gives the first
/// kind, and a table of inertial data and positions gives the inertial data; InspectFolder gives
/// all.
FileContent InspectFile(const std::filesystem::path& file);

/// Returns the contents of the entries of a folder, sorted by name. A file with several kinds of
/// data has one content for each. Folders, hidden files, YAML and
/// JSON are left out. An entry that cannot be read, such as a dangling link, is of unknown kind.
std::vector<FileContent> InspectFolder(const std::filesystem::path& folder);

}  // namespace dn
