#pragma once

#include <dn/geo/local_frame.h>
#include <dn/gnss/gnss_data.h>

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace dn {

/// A GNSS solution in the map frame m; its covariances and velocity are in local east-north-up axes
/// at the antenna.
struct MapGnssEpoch {
  double t_s = 0.0;                               ///< GPS seconds of week
  Eigen::Vector3d p_m = Eigen::Vector3d::Zero();  ///< antenna position, m
  /// Rotation from east-north-up at the antenna to m.
  Eigen::Matrix3d R_m_enu = Eigen::Matrix3d::Identity();
  /// Covariance of the position; absent: the default of the flight.
  std::optional<Eigen::Matrix3d> covariance_enu_m2;
  std::optional<Eigen::Vector3d> velocity_enu_mps;
  std::optional<Eigen::Matrix3d> velocity_covariance_enu;  ///< (m/s)^2
  long line = 0;
};

struct MapGnss {
  std::vector<MapGnssEpoch> epochs;  ///< sorted by time
};

MapGnss ToMap(const GnssData& gnss, const LocalFrame& frame);

}  // namespace dn
