#pragma once

#include <dn/imu/imu_data.h>

#include <Eigen/Core>
#include <vector>

namespace dn::navigation_internal {

/// Motion of the body by its inertial data alone, without gravitation, biases and initial values.
/// It is in the inertial frame r that coincides with the body at the first sample.
class MotionRecord {
 public:
  explicit MotionRecord(const ImuData& imu);

  /// Motion at one time.
  struct State {
    Eigen::Matrix3d R_rb;    ///< attitude
    Eigen::Vector3d p_r;     ///< double integral of the specific force, m
    Eigen::Matrix3d sum_rb;  ///< integral of R_rb, s
  };

  /// Returns the motion at a time inside the record.
  State At(double t_s) const;

  double t_begin_s() const { return nodes_.front().t_s; }
  double t_end_s() const { return nodes_.back().t_s; }

 private:
  struct Node {
    double t_s;
    State state;
    Eigen::Vector3d v_r;
  };

  std::vector<Node> nodes_;
};

}  // namespace dn::navigation_internal
