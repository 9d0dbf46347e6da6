#pragma once

#include <dn/geo/local_frame.h>
#include <dn/geo/text_coordinates.h>

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// One GNSS solution. Covariances are in the local east-north-up of the point.
struct GnssEpoch {
  double t_s = 0.0;  ///< GPS seconds of week
  Geodetic antenna;
  std::optional<Eigen::Matrix3d>
      covariance_enu_m2;  ///< of the position; absent: the flight's default
  std::optional<Eigen::Vector3d> velocity_enu_mps;
  std::optional<Eigen::Matrix3d> velocity_covariance_enu;  ///< (m/s)^2
  int quality = 0;  ///< RTKLIB: 1 fix 2 float 3 SBAS 4 DGPS 5 single 6 PPP; 0 unknown
  long line = 0;
};

/// Formats of GNSS files; see ReadGnss.
enum class GnssFormat { kOdyn, kRtklib, kObGins, kNmea };

/// GNSS solutions of one receiver, sorted by time.
struct GnssData {
  std::vector<GnssEpoch> epochs;
  long repeated_rows_dropped = 0;
  long unusable_sentences = 0;  ///< kNmea: GGA without a fix, or with a wrong checksum
};

/// What the columns of kOdyn and kObGins are where they are not geographic ones and true north.
struct GnssColumns {
  TextCoordinates position = {};
  bool grid_north = false;  ///< north and east of velocities and sigmas are those of the UTM grid
};

/// Reads a file of GNSS solutions, sorted by time; identical repeated rows are dropped and counted,
/// a backward jump of a week is continued.
///
///   kOdyn    t, lat, lon [deg], h; 7 columns: + sigma E N U; 10: + v E N U, sigma v E N U; 13: all
///   kRtklib  .pos with its header: latitude, longitude (degrees, or degrees minutes seconds) and
///            ellipsoidal height, or ECEF x, y, z; time as week and seconds or calendar, GPST, UTC
///            or JST; covariances from signed roots, made positive definite by shrinking
///            correlations where they are not; a velocity whose sigmas are all 0 was not estimated
///            and is left out
///   kObGins  t, lat, lon [deg], h, sigma N E D; 13 columns: t, lat, lon, h, v N E D, sigma N E D,
///            sigma v N E D
///
///   kNmea    sentences GGA (position; height above the geoid plus geoid separation) and RMC or ZDA
///            (date) of any talker; UTC becomes GPS time by the leap seconds of the date; no sigmas.
///            Other sentences, those without a fix and those whose checksum is wrong are left out
///
/// time_offset_s: known error of the tags, tag = t + value, removed first; seconds since 1980 are so
/// brought to seconds of week, too.
///
/// Throws InvalidInput naming file:line: sigmas that are not positive, coordinates out of range,
/// values that are not finite, wrong numbers of columns, times that do not increase.
GnssData ReadGnss(const std::filesystem::path& file, GnssFormat format, double time_offset_s = 0.0,
                  const GnssColumns& columns = {});

}  // namespace dn
