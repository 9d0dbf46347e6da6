#pragma once

#include <dn/geo/local_frame.h>
#include <dn/gnss/gnss_data.h>

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace dn {

/// A GNSS solution in the mapping frame m; covariances and the velocity stay in the local
/// east-north-up of the antenna.
struct MapGnssEpoch {
  double t_s = 0.0;                                       ///< GPS seconds of week
  Eigen::Vector3d p_m = Eigen::Vector3d::Zero();          ///< antenna, m
  Eigen::Matrix3d R_m_enu = Eigen::Matrix3d::Identity();  ///< from the antenna's east-north-up
  std::optional<Eigen::Matrix3d>
      covariance_enu_m2;  ///< of the position; absent: the flight's default
  std::optional<Eigen::Vector3d> velocity_enu_mps;
  std::optional<Eigen::Matrix3d> velocity_covariance_enu;  ///< (m/s)^2
  long line = 0;
};

struct MapGnss {
  std::vector<MapGnssEpoch> epochs;  ///< sorted by time
};

MapGnss ToMap(const GnssData& gnss, const LocalFrame& frame);

}  // namespace dn
