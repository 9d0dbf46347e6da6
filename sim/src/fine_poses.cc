#include "fine_poses.h"

#include <algorithm>
#include <cmath>

namespace dn {
namespace {

constexpr double kStep_s = 2e-3;
constexpr double kStepsPerPeriod = 8.0;

double LongestStep(const TruthTrajectory& truth) {
  const double vibration_hz = truth.vibration_hz();
  return vibration_hz > 0.0 ? std::min(kStep_s, 1.0 / (kStepsPerPeriod * vibration_hz)) : kStep_s;
}

/// Returns the cubic between two values with given derivatives; x in [0, 1] is the fraction of the
/// step.
template <class V>
V Cubic(const V& a, const V& a_rate, const V& b, const V& b_rate, double step_s, double x) {
  const double y = 1.0 - x;
  return y * y * (1.0 + 2.0 * x) * a + x * x * (1.0 + 2.0 * y) * b +
         step_s * x * y * (y * a_rate - x * b_rate);
}

}  // namespace

FinePoses::FinePoses(const TruthTrajectory& truth, double begin_s, double end_s)
    : begin_s_(begin_s) {
  const int steps =
      std::max(1, static_cast<int>(std::ceil((end_s - begin_s) / LongestStep(truth))));
  step_s_ = std::max((end_s - begin_s) / steps, 1e-9);
  for (int i = 0; i <= steps; ++i) {
    const TruthState state = truth.State(std::min(begin_s + i * step_s_, truth.t_end_s()));
    const Eigen::Quaterniond turn(0.0, state.w_mb_b.x(), state.w_mb_b.y(), state.w_mb_b.z());
    Knot knot{state.pose.p_mb, state.pose.v_m, state.pose.q_mb.coeffs(),
              0.5 * (state.pose.q_mb * turn).coeffs()};
    if (!knots_.empty() && knots_.back().q.dot(knot.q) < 0.0) {
      knot.q = -knot.q;
      knot.q_rate = -knot.q_rate;
    }
    knots_.push_back(knot);
  }
}

MapPose FinePoses::At(double t_s) const {
  const double steps = (t_s - begin_s_) / step_s_;
  const double last = static_cast<double>(knots_.size()) - 2.0;
  const double knot = std::clamp(std::floor(steps), 0.0, last);
  const Knot& a = knots_[static_cast<std::size_t>(knot)];
  const Knot& b = knots_[static_cast<std::size_t>(knot) + 1];
  const double x = steps - knot;
  MapPose pose;
  pose.t_s = t_s;
  pose.p_mb = Cubic(a.p_m, a.v_mps, b.p_m, b.v_mps, step_s_, x);
  pose.v_m = a.v_mps + x * (b.v_mps - a.v_mps);
  const Eigen::Vector4d q = Cubic(a.q, a.q_rate, b.q, b.q_rate, step_s_, x).normalized();
  pose.q_mb = Eigen::Quaterniond(q);
  return pose;
}

}  // namespace dn
