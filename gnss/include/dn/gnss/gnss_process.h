#pragma once

#include <dn/eigen_alignment.h>

#include <Eigen/Core>

namespace dn {

/// Time-correlated error of the GNSS positions: one first-order Gauss-Markov process on each local
/// east, north and up axis of the point. The axes are independent.
struct GnssProcess {
  /// Stationary standard deviation; 0: no error on that axis.
  Eigen::Vector3d sigma_enu_m = Eigen::Vector3d::Zero();
  double tau_s = 0.0;  ///< correlation time

  friend bool operator==(const GnssProcess&, const GnssProcess&) = default;
};

}  // namespace dn
