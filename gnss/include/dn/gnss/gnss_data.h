#pragma once

#include <dn/eigen_alignment.h>
#include <dn/geo/local_frame.h>
#include <dn/geo/named_columns.h>
#include <dn/geo/text_coordinates.h>

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// One GNSS solution. Covariances refer to the local east-north-up axes at the point.
struct GnssEpoch {
  double t_s = 0.0;  ///< GPS seconds of week
  Geodetic antenna;
  /// Covariance of the position; absent: the default of the flight applies.
  std::optional<Eigen::Matrix3d> covariance_enu_m2;
  std::optional<Eigen::Vector3d> velocity_enu_mps;
  std::optional<Eigen::Matrix3d> velocity_covariance_enu;  ///< (m/s)^2
  /// As in RTKLIB, also for kNmea: 1 fix, 2 float, 3 SBAS, 4 DGPS, 5 single, 6 PPP; 0 unknown.
  int quality = 0;
  long line = 0;  ///< line of the file, from 1
};

/// Formats of GNSS files; see ReadGnss.
enum class GnssFormat { kOdyn, kRtklib, kObGins, kNmea };

/// GNSS solutions of one receiver, sorted by time.
struct GnssData {
  std::vector<GnssEpoch> epochs;
  long repeated_rows_dropped = 0;
  long unusable_sentences = 0;  ///< kNmea: GGA sentences without a fix or with a wrong checksum
  std::map<std::string, long> counts;  ///< rows that are unusual or left out, by reason

  void Count(const std::string& reason, long rows) {
    if (rows != 0) counts[reason] += rows;
  }
};

/// Quantities of the columns of a file of GNSS solutions.
const std::vector<std::string>& GnssQuantities();

/// Coordinate system of the columns of kOdyn and kObGins. By default the positions are geographic
/// and north is true north.
struct GnssColumns {
  TextCoordinates position = {};
  bool grid_north = false;  ///< velocities and sigmas refer to north and east of the UTM grid
  /// For kOdyn: names of the columns (t, lat, lon, h, sigma_e ..., ve ..., sigma_ve ...); empty: by
  /// their number. Only complete triples are used.
  ColumnNames names = {};
  /// For kOdyn with names: rows without a position (empty, or a latitude and longitude of 0) and
  /// rows that repeat the position of the row before are left out and counted. A log of several
  /// sensors has them.
  bool only_changed = false;
};

/// Reads a file of GNSS solutions and sorts them by time. Identical repeated rows are dropped and
/// counted. A backward jump of a week counts as a week rollover: later times continue beyond it.
///
///   kOdyn    t, lat, lon [deg], h; 7 columns: + sigma E N U; 10: + v E N U, sigma v E N U; 13: all
///   kRtklib  .pos with its header: latitude and longitude (degrees, or degrees minutes seconds)
///            and ellipsoidal height, or ECEF x, y, z; time as week and seconds or as calendar
///            date, in GPST, UTC or JST. Covariances come from signed roots; an indefinite one
///            becomes positive definite by shrinking its correlations. A velocity whose sigmas
///            are all 0 was not estimated and is ignored. A file without a header is read if its
///            rows have the columns of a complete solution; its time is then taken as GPST.
///   kObGins  t, lat, lon [deg], h, sigma N E D; 13 columns: t, lat, lon, h, v N E D, sigma N E D,
///            sigma v N E D
///   kNmea    sentences GGA (position; height above the geoid plus geoid separation) and RMC or ZDA
///            (date); UTC becomes GPS time by the leap seconds of the date; the file has no
///            sigmas. The date is that of the first valid RMC within a day of most others, or of a
///            ZDA near the first position. The most frequent talker is used, but GN if it is not
///            much rarer. Text before a sentence with a checksum is ignored. Sentences without a
///            fix, with a wrong checksum, without geoid separation, and of quality 6 to 8 (not
///            measured) are left out and counted.
///
/// Position sigmas that are all 0 are unknown. If other rows have sigmas, such rows are left out
/// and counted. A velocity whose sigmas are all 0 is unknown, too.
///
/// time_offset_s: known error of the time tags (tag = t + time_offset_s), subtracted first. It can
/// also convert seconds since 1980 to seconds of week.
///
/// Throws InvalidInput with file:line for sigmas that are not positive, coordinates out of range,
/// and values that are not finite. Also throws for a wrong number of columns, and for times that do
/// not increase.
GnssData ReadGnss(const std::filesystem::path& file, GnssFormat format, double time_offset_s = 0.0,
                  const GnssColumns& columns = {});

}  // namespace dn
