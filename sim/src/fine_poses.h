#pragma once

#include <dn/sim/truth.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

namespace dn {

/// True poses of a short time, many of them: cubics through exact ones every 2 ms, with their
/// velocities and angular rates. Within 1e-7 m and 1e-9 rad of the truth for motion up to some Hz.
class FinePoses {
 public:
  FinePoses(const TruthTrajectory& truth, double begin_s, double end_s);

  /// t_s within the time it was made for.
  MapPose At(double t_s) const;

 private:
  struct Knot {
    Eigen::Vector3d p_m, v_mps;
    Eigen::Vector4d q, q_rate;  // map from body, the sign of the knot before
  };
  double begin_s_;
  double step_s_;
  std::vector<Knot> knots_;
};

}  // namespace dn
