#pragma once

#include <dn/geo/local_frame.h>
#include <dn/geo/trajectory.h>
#include <dn/imu/imu_data.h>

#include <vector>

namespace dn {

/// Returns the data of a perfect sensor on a given motion. The strapdown equations of EarthStep are
/// solved for the increments between the poses at both ends of each sample. The mean rate w and
/// mean specific force f follow from the increments:
///
///   phi = Log(R_i^T C R_j),                w = phi / dt
///   dv  = R_i^T (C (v_j + w x rho_j) - (v_i + w x rho_i) - dt/2 (G_i + C G_j)),   f = Jl(phi)^-1
///         dv / dt
///
/// It serves to simulate data for a plan, which has poses but no measurements. InterpolatePose is
/// used between the poses of the motion. The poses should be as dense as the samples if steps in
/// attitude matter at the level of the noise.
///
/// Accuracy for poses as dense as the samples: the error is that of assuming constant rate and
/// specific force in body over one sample. It is 1e-5 m/s^2 at 100 Hz in a turn.
///
/// motion: at least two poses with velocities, sorted by time. rate_hz must be positive. The
/// samples begin at the first pose and end at most one sample before the last pose. Throws
/// InvalidInput if the motion is shorter than one sample.
ImuData ImpliedImu(const LocalFrame& frame, const std::vector<MapPose>& motion, double rate_hz);

}  // namespace dn
