#pragma once

#include <dn/imu/imu_data.h>

namespace dn {

/// White noise densities that rows of inertial data show.
struct WhiteRows {
  double gyro_rad_per_sqrt_s = 0.0;
  double accel_mps_per_sqrt_s = 0.0;
};

/// From the second differences d of the rows over a second, of which white noise leaves
/// var(d) = 6 sigma^2: N = sigma sqrt(dt), the median of all seconds, of the axis with the most.
/// Slow motion cancels; vibration that the platform has most of the time is in it. Rows that repeat
/// the row before are left out. Zero where no second has five rows of its own.
WhiteRows WhiteNoiseOfRows(const ImuData& imu);

}  // namespace dn
