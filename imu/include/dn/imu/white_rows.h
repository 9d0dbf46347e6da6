#pragma once

#include <dn/imu/imu_data.h>

namespace dn {

/// White noise densities estimated from the rows of inertial data.
struct WhiteNoiseDensities {
  double gyro_rad_per_sqrt_s = 0.0;
  double accel_mps_per_sqrt_s = 0.0;
};

/// Estimates the white noise from second differences d of the rows: white noise has
/// var(d) = 6 sigma^2, and N = sigma sqrt(dt). The result is the median over all seconds, for the
/// axis with the largest noise. Slow motion cancels; vibration that is present most of the time is
/// included. Rows that repeat the row before are ignored. The result is zero if no second has five
/// distinct rows.
WhiteNoiseDensities EstimateWhiteNoise(const ImuData& imu);

}  // namespace dn
