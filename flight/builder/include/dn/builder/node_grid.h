#pragma once

#include <dn/gnss/gnss_data.h>
#include <dn/imu/imu_data.h>

#include <vector>

namespace dn {

/// Spacing of the trajectory nodes of a network.
struct NodeGridOptions {
  double rate_in_strips_hz = 5.0;  ///< within `dense`; > 0
  double max_spacing_s = 1.0;      ///< outside of `dense`; > 0
  bool every_imu_epoch = false;    ///< for raw inertial edges: a node at every IMU epoch
};

/// A time interval, s.
struct TimeInterval {
  double t0_s = 0.0;
  double t1_s = 0.0;
};

/// Returns node times, strictly increasing. Nodes are at every GNSS epoch and at the ends of the
/// span and of IMU gaps. The intervals between them are divided equally, into parts of at most 1 /
/// rate_in_strips_hz within `dense` and max_spacing_s elsewhere. There are no nodes inside an IMU
/// gap. gnss_t_s must be sorted; epochs outside the span are ignored. Throws InvalidConfig if an
/// option is not positive or the nodes would be too many for the memory, InvalidInput if the span
/// is empty.
std::vector<double> NodeTimes(const ImuData& imu, const TimeInterval& span,
                              const std::vector<double>& gnss_t_s,
                              const std::vector<TimeInterval>& dense,
                              const NodeGridOptions& options);

/// Returns the index of the last node at or before t_s; 0 if t_s is before the first node.
std::size_t NodeBefore(const std::vector<double>& node_t_s, double t_s);

/// Returns the index of the node nearest to t_s.
std::size_t NodeNear(const std::vector<double>& node_t_s, double t_s);

/// Returns intervals that contain the epochs. Neighbouring epochs at most `join_s` apart are in the
/// same interval.
std::vector<TimeInterval> ClusterEpochs(std::vector<double> t_s, double join_s);

}  // namespace dn
