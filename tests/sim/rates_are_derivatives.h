#pragma once

#include <dn/rotation.h>
#include <dn/sim/truth.h>
#include <gtest/gtest.h>

namespace dn::sim_test {

/// Bounds of the differences between derivatives of the pose and the rates of a truth.
struct RateTolerances {
  double velocity_mps = 0.0, acceleration_mps2 = 0.0, rate_radps = 0.0;
};

/// Expects velocity, acceleration and rate to be the fourth-order differences of the pose. The step
/// should be a power of two, so that times are exact.
inline void ExpectRatesAreDerivatives(const TruthTrajectory& truth, double step_s,
                                      const RateTolerances& tolerances) {
  using Eigen::Vector3d;
  const auto difference = [step_s](auto at, double t_s) -> Vector3d {
    return (8.0 * (at(t_s + step_s) - at(t_s - step_s)) -
            (at(t_s + 2.0 * step_s) - at(t_s - 2.0 * step_s))) /
           (12.0 * step_s);
  };
  for (double t_s = truth.t_begin_s() + 1.0; t_s < truth.t_end_s() - 1.0; t_s += 1.25) {
    SCOPED_TRACE(t_s);
    const TruthState state = truth.State(t_s);
    const Vector3d v = difference([&](double t) { return truth.Pose(t).p_mb; }, t_s);
    const Vector3d a = difference([&](double t) { return truth.Pose(t).v_m; }, t_s);
    const Vector3d w = difference(
        [&](double t) { return Log<double>(state.pose.q_mb.conjugate() * truth.Pose(t).q_mb); },
        t_s);
    EXPECT_LT((v - state.pose.v_m).norm(), tolerances.velocity_mps);
    EXPECT_LT((a - state.a_m).norm(), tolerances.acceleration_mps2);
    EXPECT_LT((w - state.w_mb_b).norm(), tolerances.rate_radps);
  }
}

}  // namespace dn::sim_test
