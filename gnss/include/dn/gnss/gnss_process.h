#pragma once

#include <Eigen/Core>

namespace dn {

/// An error of the GNSS positions that lasts: a first-order Gauss-Markov process on each axis of the
/// local east-north-up of the point, the axes independent of one another.
struct GnssProcess {
  Eigen::Vector3d sigma_enu_m = Eigen::Vector3d::Zero();  ///< stationary; 0: no error on that axis
  double tau_s = 0.0;                                     ///< correlation time

  friend bool operator==(const GnssProcess&, const GnssProcess&) = default;
};

}  // namespace dn
