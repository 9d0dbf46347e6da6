#pragma once

#include <optional>

namespace dn {

/// The clock of a sensor against that of the inertial data:
///
///   tag = t + offset + drift (t - first),
///
/// first: the earliest epoch of the sensor. Those are gnss_time_offset and gnss_time_drift, or
/// lidar_time_offset and lidar_time_drift.
struct ClockEstimate {
  double offset_s = 0.0;
  double sigma_offset_s = 0.0;
  double drift = 0.0;  ///< seconds per second
  double sigma_drift = 0.0;
  double correlation = 0.0;  ///< of the two; 0 where one of them is an unknown of the adjustment

  /// The same data where there is no drift, or no offset.
  ClockEstimate WithoutDrift() const;
  ClockEstimate WithoutOffset() const;

  /// Beyond four sigmas.
  bool shows_offset() const { return offset_s * offset_s > 16.0 * sigma_offset_s * sigma_offset_s; }
  bool shows_drift() const { return drift * drift > 16.0 * sigma_drift * sigma_drift; }
};

/// Absent where the sensor has no data in the adjustment, or the flight does not tell offset and
/// drift from everything else.
struct Clocks {
  std::optional<ClockEstimate> gnss, lidar;
};

}  // namespace dn
