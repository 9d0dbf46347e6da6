#pragma once

#include <dn/geo/local_frame.h>
#include <dn/geo/trajectory.h>
#include <dn/imu/imu_data.h>

#include <vector>

namespace dn {

/// What a perfect sensor measures on a motion: the strapdown equations of EarthStep solved for the
/// increments between the poses at the ends of each sample, and those for their means,
///
///   phi = Log(R_i^T C R_j),                w = phi / dt
///   dv  = R_i^T (C (v_j + w x rho_j) - (v_i + w x rho_i) - dt/2 (G_i + C G_j)),   f = Jl(phi)^-1
///         dv / dt
///
/// for a plan, which has poses and no readings. Between the poses of the motion InterpolatePose
/// holds: they should be as dense as the samples where the noise of an attitude step matters.
///
/// Accuracy for poses as dense as the samples: that of a rate and a specific force constant in
/// body over one sample, 1e-5 m/s^2 at 100 Hz in a turn.
///
/// motion: by time, at least two, with velocities. rate_hz > 0. The samples begin at the first pose
/// and end at the last or less than a sample before it. Throws InvalidInput where there is not a
/// single sample.
ImuData ImpliedImu(const LocalFrame& frame, const std::vector<MapPose>& motion, double rate_hz);

}  // namespace dn
