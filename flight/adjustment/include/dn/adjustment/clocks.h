#pragma once

#include <optional>

namespace dn {

/// Error of a sensor's clock with respect to the inertial clock:
///
///   tag = t + offset + drift (t - first),
///
/// where `first` is the earliest epoch of the sensor. Offset and drift are the effects
/// gnss_time_offset and gnss_time_drift, or lidar_time_offset and lidar_time_drift.
struct ClockEstimate {
  double offset_s = 0.0;
  double sigma_offset_s = 0.0;
  double drift = 0.0;  ///< seconds per second
  double sigma_drift = 0.0;
  /// Correlation of offset and drift; 0 if one of them is an unknown of the adjustment.
  double correlation = 0.0;

  /// Returns the estimate from the same data with the drift, or the offset, constrained to zero.
  ClockEstimate WithoutDrift() const;
  ClockEstimate WithoutOffset() const;

  /// Returns true if the value exceeds four sigmas.
  bool shows_offset() const { return offset_s * offset_s > 16.0 * sigma_offset_s * sigma_offset_s; }
  bool shows_drift() const { return drift * drift > 16.0 * sigma_drift * sigma_drift; }
};

/// Clock errors of the sensors. One is absent if the sensor has no data in the adjustment, or if
/// the flight cannot separate offset and drift from the other unknowns. It is also absent if it is
/// known only to first order and exceeds 0.2 s (GNSS) or 0.05 s (lidar).
struct Clocks {
  std::optional<ClockEstimate> gnss, lidar;
};

}  // namespace dn
