#pragma once

#include <dn/imu/imu_data.h>

namespace dn {

/// White noise densities estimated from the rows of inertial data.
struct WhiteNoiseDensities {
  double gyro_rad_per_sqrt_s = 0.0;
  double accel_mps_per_sqrt_s = 0.0;
  /// The platform shakes during the whole record, for example by its engine. The densities are then
  /// the lowest levels of the spectra, and those of the sensor may be lower.
  bool shaking = false;
};

/// Estimates the white noise of the axis with the largest one. The calmest tenth of the record
/// counts, in parts of 512 samples. Its mean power in the upper half of the frequencies is the
/// noise if it is white there. Otherwise the lowest level between the lines of the spectrum counts.
///
/// Records without three such parts, and those that repeat rows, use second differences d of the
/// rows. White noise has var(d) = 6 sigma^2, and N = sigma sqrt(dt). The result is then the median
/// over all seconds, and includes vibration. It is zero if no second has five distinct rows.
WhiteNoiseDensities EstimateWhiteNoise(const ImuData& imu);

}  // namespace dn
