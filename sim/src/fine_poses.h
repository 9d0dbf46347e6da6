#pragma once

#include <dn/sim/truth.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

namespace dn {

/// Computes many true poses within a short time. It interpolates exact poses every 2 ms by cubics
/// with their velocities and angular rates. The error is below 1e-7 m and 1e-9 rad for motion up to
/// a few Hz. Vibration shortens the step to an eighth of its shortest period, which gives errors of
/// 0.1 % of its amplitude.
class FinePoses {
 public:
  FinePoses(const TruthTrajectory& truth, double begin_s, double end_s);

  /// Returns the pose at t_s, which must lie in the span given to the constructor.
  MapPose At(double t_s) const;

 private:
  struct Knot {
    Eigen::Vector3d p_m, v_mps;
    Eigen::Vector4d q, q_rate;  // map from body, with the sign of the knot before
  };
  double begin_s_;
  double step_s_;
  std::vector<Knot> knots_;
};

}  // namespace dn
