#pragma once

#include <dn/imu/imu_data.h>

#include <algorithm>
#include <vector>

namespace dn::internal {

/// The bridges of samples that are visited in the order of time.
class BridgeCursor {
 public:
  /// From the first sample after t_s on.
  BridgeCursor(const ImuData& imu, double t_s)
      : next_(std::upper_bound(imu.bridges.begin(), imu.bridges.end(), t_s,
                               [](double t, const ImuBridge& b) { return t < b.row.t_s; })),
        end_(imu.bridges.end()) {}

  /// The one whose hole the sample stands for, too; null: none.
  const ImuBridge* Of(const ImuSample& sample) {
    while (next_ != end_ && next_->row.t_s < sample.t_s) ++next_;
    return next_ == end_ || next_->row.t_s > sample.t_s ? nullptr : &*next_;
  }

 private:
  std::vector<ImuBridge>::const_iterator next_, end_;
};

}  // namespace dn::internal
