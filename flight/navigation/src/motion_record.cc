#include "motion_record.h"

#include <dn/rotation.h>

#include <Eigen/Geometry>
#include <algorithm>

namespace dn::navigation_internal {
namespace {

// Between two nodes, the acceleration is constant: the error is below a millimetre at 1 m/s^3.
constexpr double kNodeSpacingS = 0.05;

}  // namespace

MotionRecord::MotionRecord(const ImuData& imu) {
  const ImuSample& first = imu.samples.front();
  Eigen::Quaterniond q_rb = Eigen::Quaterniond::Identity();
  Node now{first.t_s - first.dt_s,
           {Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero()},
           Eigen::Vector3d::Zero()};
  nodes_.push_back(now);
  for (const ImuSample& sample : imu.samples) {
    const double dt_s = sample.t_s - now.t_s;  // a gap is bridged with the sample after it
    const Eigen::Quaterniond half = Exp(Eigen::Vector3d(0.5 * dt_s * sample.w_ib_b_radps));
    const Eigen::Matrix3d R_middle = (q_rb * half).toRotationMatrix();
    const Eigen::Vector3d f_r = R_middle * sample.f_b_mps2;
    now.state.p_r += dt_s * now.v_r + 0.5 * dt_s * dt_s * f_r;
    now.v_r += dt_s * f_r;
    now.state.sum_rb += dt_s * R_middle;
    q_rb = (q_rb * half * half).normalized();
    now.t_s = sample.t_s;
    if (now.t_s - nodes_.back().t_s < kNodeSpacingS) continue;
    now.state.R_rb = q_rb.toRotationMatrix();
    nodes_.push_back(now);
  }
}

MotionRecord::State MotionRecord::At(double t_s) const {
  auto after = std::upper_bound(nodes_.begin(), nodes_.end(), t_s,
                                [](double t, const Node& node) { return t < node.t_s; });
  after = std::clamp(after, nodes_.begin() + 1, nodes_.end() - 1);
  const Node &a = *(after - 1), &b = *after;
  const double step_s = b.t_s - a.t_s, dt_s = t_s - a.t_s, share = dt_s / step_s;
  State at = a.state;
  at.R_rb += share * (b.state.R_rb - a.state.R_rb);
  at.sum_rb += share * (b.state.sum_rb - a.state.sum_rb);
  at.p_r += dt_s * a.v_r + 0.5 * dt_s * share * (b.v_r - a.v_r);
  return at;
}

}  // namespace dn::navigation_internal
