#pragma once

#include <dn/imu/imu_data.h>

#include <algorithm>
#include <vector>

namespace dn::imu_internal {

/// Finds the bridges of samples that are visited in time order.
class BridgeCursor {
 public:
  /// Starts at the first sample after t_s.
  BridgeCursor(const ImuData& imu, double t_s)
      : next_(std::upper_bound(imu.bridges.begin(), imu.bridges.end(), t_s,
                               [](double t, const ImuBridge& b) { return t < b.row.t_s; })),
        end_(imu.bridges.end()) {}

  /// Returns the bridge whose hole this sample also covers; nullptr if there is no such bridge.
  const ImuBridge* Find(const ImuSample& sample) {
    while (next_ != end_ && next_->row.t_s < sample.t_s) ++next_;
    return next_ == end_ || next_->row.t_s > sample.t_s ? nullptr : &*next_;
  }

 private:
  std::vector<ImuBridge>::const_iterator next_, end_;
};

}  // namespace dn::imu_internal
