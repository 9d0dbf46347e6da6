#pragma once

#include <dn/diagnosis/diagnosis.h>
#include <dn/files/flight.h>

#include <string>
#include <vector>

namespace dn {

/// Returns the configuration of the flight with the given effects modelled by the estimator:
///
///   fixed effects             an entry under `estimate`, free; accel_scale_factor,
///                             accel_misalignment, gravity_tilt and gravity_disturbance with a
///                             prior of max(10 x typical, 3 x |estimate|), without which the first
///                             INS/GNSS solution does not settle
///   gnss_correlated_noise     one more element of gnss.processes
///   gnss_multipath            one more element of gnss.processes, with grows_with: bank
///   gnss_noise_scale          gnss.sigma_scale, and velocity_sigma_scale if stated, x ratio
///   gyro, accel_noise_scale   white noise x ratio
///   gyro, accel_bias_process  one more gauss_markov process
///   imu_vibration             one more element of imu.vibration, with its window
///   p2p_noise_scale           lidar.sigma_p_m x ratio
///   p2p_range_noise           sigma_p_m^2 + (sigma per range x mean range)^2
///   p2p_outliers              lidar.robust: cauchy
///   gnss_outliers             gnss.robust: huber
///   faults of the data        nothing: no key models them
///
/// Leaves an unknown that is already estimated and a robust loss that is already chosen as they
/// are. Throws InvalidInput for an effect that is not in the table and for a value that ToFileValue
/// rejects. Also throws for a vibration without its window, and if flight.yaml lacks the section of
/// the sensor.
FlightConfig Adapted(const Flight& flight, const std::vector<GapCause>& causes);

/// Returns the configuration with the effects named by the diagnosis, and with those that heavy
/// tails replaced (GapVerdict::heavy_tails): a robust loss also suits the tails. Sets `unexplained`
/// to a description of the gap that is left, so that the flight is not reported as calibrated.
FlightConfig Adapted(const Flight& flight, const GapDiagnosis& diagnosis);

/// Returns the key of flight.yaml that Adapted changes for an effect, such as "estimate" or
/// "gnss.processes". Returns "" for a data fault, which flight.yaml cannot model.
std::string AdaptedKey(const std::string& effect);

/// Returns the causes that the verdict names, in the order of the verdict.
std::vector<GapCause> VerdictCauses(const GapDiagnosis& diagnosis);

/// Returns the estimate in the file's unit, clamped to the bounds of the effect table (a negative
/// sigma becomes 0). Throws InvalidInput for a value that is not finite and for a wrong number of
/// values.
std::vector<double> ToFileValue(const GapCause& cause);

}  // namespace dn
