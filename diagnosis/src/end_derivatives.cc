#include "end_derivatives.h"

#include <dn/rotation.h>

#include <algorithm>

namespace dn::diagnosis_internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Half the step of the numerical derivatives with respect to time.
constexpr double kHalfStep_s = 5e-3;

}  // namespace

EndDerivatives::EndDerivatives(const Flight& flight, const Vector3d& lever_arm_b_m,
                               const Vector3d& boresight_rad)
    : R_bs_nominal_(flight.config.lidar->mounting.R_bs_nominal),
      lever_arm_b_m_(lever_arm_b_m),
      q_boresight_(Exp(boresight_rad)),
      left_jacobian_(RightJacobian(-boresight_rad)),
      first_s_(flight.trajectory->points().front().t_s),
      last_s_(flight.trajectory->points().back().t_s),
      poses_(flight.trajectory->ToMapPoses(flight.frame)) {}

Vector3d EndDerivatives::PointVelocity(double t_s, const Vector3d& s_b) const {
  const double t0_s = std::max(first_s_, t_s - kHalfStep_s);
  const double t1_s = std::min(last_s_, t_s + kHalfStep_s);
  const MapPose a = poses_.At(t0_s), b = poses_.At(t1_s);
  return (b.p_mb + b.q_mb * s_b - a.p_mb - a.q_mb * s_b) / (t1_s - t0_s);
}

PairEnd EndDerivatives::At(const GaussHelmertEnd& end, const Vector3d& v_phi_rad,
                           const Matrix3d& W) const {
  PairEnd out;
  out.t_s = end.t_s;
  out.u_s = R_bs_nominal_.transpose() * end.u_b;
  out.J_r_a = W * (end.q_mb * Exp(v_phi_rad)).toRotationMatrix();
  out.J_r_u = out.J_r_a * q_boresight_.toRotationMatrix() * R_bs_nominal_;
  out.J_r_turn = -out.J_r_a * Skew(q_boresight_ * end.u_b) * left_jacobian_;
  out.J_r_t = -W * PointVelocity(end.t_s, lever_arm_b_m_ + q_boresight_ * end.u_b);
  return out;
}

}  // namespace dn::diagnosis_internal
