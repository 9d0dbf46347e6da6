#pragma once

#include <dn/geo/local_frame.h>

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

enum class GnssFormat { kOdyn, kRtklib, kObGins };

struct GnssData {
  std::vector<GnssEpoch> epochs;
  long repeated_rows_dropped = 0;
};

/// Reads GPS.txt (4, 7, 10 or 13 columns, see the contract), RTKLIB .pos (geodetic, ECEF xyz; GPST
/// or UTC; week/tow or calendar) or OB_GINS/KF-GINS GNSS text. Throws InvalidInput naming
/// file:line.
GnssData ReadGnss(const std::filesystem::path& file, GnssFormat format);

}  // namespace dn
