#pragma once

#include <dn/flight/flight.h>
#include <dn/gap/diagnosis.h>

#include <string>
#include <vector>

namespace dn {

/// The configuration of a flight with these effects in the estimator:
///
///   fixed effects             an entry under `estimate`, free; accel_scale_factor,
///                             accel_misalignment, gravity_tilt and gravity_disturbance with a
///                             prior of max(10 x typical, 3 x |estimate|), without which the first
///                             INS/GNSS solution does not settle
///   gnss_correlated_noise     one more element of gnss.processes
///   gnss_noise_scale          gnss.sigma_scale x ratio
///   gyro, accel_noise_scale   white noise x ratio
///   gyro, accel_bias_process  one more gauss_markov process
///   imu_vibration             one more element of imu.vibration, with its window
///   p2p_noise_scale           lidar.sigma_p_m x ratio
///   p2p_range_noise           sigma_p_m^2 + (sigma per range x mean range)^2
///   p2p_outliers              lidar.robust: cauchy
///   gnss_outliers             gnss.robust: huber
///   faults of the data        nothing: no key models them
///
/// An unknown that is estimated already, and a robust loss that is chosen, stay as they are.
/// Throws InvalidInput for an effect that is not in the table, as FileValue does, for a vibration
/// without its window, and where the flight has not the section of its sensor.
FlightConfig Adapted(const Flight& flight, const std::vector<GapCause>& causes);

/// With what a diagnosis names, and in words what it could not explain (`unexplained`), which keeps
/// the flight from being called calibrated.
FlightConfig Adapted(const Flight& flight, const GapDiagnosis& diagnosis);

/// What Adapted changes of flight.yaml for an effect: "estimate", "gnss.processes". Empty for a
/// fault, which no key models.
std::string AdaptedKey(const std::string& effect);

/// The causes that the verdict names, in its order.
std::vector<GapCause> CausesOfVerdict(const GapDiagnosis& diagnosis);

/// The estimate as files take it, in its unit: what lies beyond a bound of the table, as a sigma
/// below 0, is brought to it. Throws InvalidInput for a value that is no number, and a wrong number
/// of them.
std::vector<double> FileValue(const GapCause& cause);

}  // namespace dn
