#pragma once

#include <dn/geo/trajectory.h>
#include <dn/gnss/gnss_process.h>

#include <Eigen/Core>

namespace dn {

/// Returns the stationary standard deviations of a process of GNSS errors at the attitude of a
/// pose, local east, north, up, m. For an error that grows with the bank they are
///
///   sigma_enu(pose) = sigma_enu |roll| / 30 deg,
///   |roll| = atan2(|up_m . y_m|, -up_m . z_m)      [rad], 0 to pi
///
/// with the axes y_m (right) and z_m (down) of the body and the local vertical up_m, in map. The
/// network takes the factor |roll| / 30 deg from its present trajectory as a constant. Its
/// derivative by the attitude is at most |e| / |roll| for an error of e metres: 0.06 m/rad for 3 cm
/// at 30 deg. A lever arm of a metre has 1 m/rad, and an attitude known to 1 mrad changes the error
/// by 0.06 mm.
Eigen::Vector3d GnssProcessSigma(const GnssProcess& process, const MapPose& pose,
                                 const Eigen::Vector3d& up_m);

}  // namespace dn
