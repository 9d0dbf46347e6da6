#pragma once

#include <dn/gnss/gnss_data.h>
#include <dn/imu/imu_data.h>

#include <vector>

namespace dn {

/// Where the trajectory nodes of a network stand in time.
struct NodeGridOptions {
  double rate_in_strips_hz = 5.0;  ///< within `dense`; > 0
  double max_spacing_s = 1.0;      ///< outside of it; > 0
  bool every_imu_epoch = false;    ///< raw inertial: a node at every IMU epoch
};

/// A time interval, s.
struct TimeInterval {
  double t0_s = 0.0;
  double t1_s = 0.0;
};

/// Node times, strictly increasing: every GNSS epoch, the ends of the span and of IMU gaps, and in
/// between equal divisions no longer than 1 / rate within `dense` and max_spacing_s elsewhere. None
/// inside an IMU gap.
/// gnss_t_s must be sorted; epochs outside the span are ignored.
std::vector<double> NodeTimes(const ImuData& imu, const TimeInterval& span,
                              const std::vector<double>& gnss_t_s,
                              const std::vector<TimeInterval>& dense,
                              const NodeGridOptions& options);

/// Index of the last node at or before t_s; 0 when t_s is before the first.
std::size_t NodeBefore(const std::vector<double>& node_t_s, double t_s);

/// Index of the node nearest to t_s.
std::size_t NodeNear(const std::vector<double>& node_t_s, double t_s);

/// Intervals that hold the epochs: joined where the hole between two neighbours is at most
/// `join_s`.
std::vector<TimeInterval> ClusterEpochs(std::vector<double> t_s, double join_s);

}  // namespace dn
