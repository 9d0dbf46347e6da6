#include <dn/imu/strapdown.h>
#include <dn/rotation.h>

#include <cmath>

namespace dn {
namespace {

/// Returns sin(x)/x - 1, relative accuracy 1e-15.
double SincMinusOne(double x) {
  const double x2 = x * x;
  if (x2 > 0.25) return std::sin(x) / x - 1.0;
  double term = 1.0, sum = 0.0;  // sum_k (-x^2)^k / (2k + 1)!
  for (int k = 1; k <= 8; ++k) {
    term *= -x2 / (2.0 * k * (2.0 * k + 1.0));
    sum += term;
  }
  return sum;
}

/// Returns (1 - cos x) / x^2, relative accuracy 1e-15.
double VersinOverSquare(double x) {
  const double sinc = 1.0 + SincMinusOne(0.5 * x);
  return 0.5 * sinc * sinc;
}

}  // namespace

EarthStep EarthStep::Make(const LocalFrame& frame, double dt_s) {
  const Eigen::Vector3d phi = frame.w_ie_m() * dt_s;
  const double angle = phi.norm();
  const double sinc_minus_one = SincMinusOne(angle);
  const double versin = VersinOverSquare(angle);
  const Eigen::Vector3d turn_m = phi.cross(frame.r0_m());
  const Eigen::Vector3d w_x_r0 = frame.w_ie_m().cross(frame.r0_m());
  const Eigen::Matrix3d S = Skew(phi);

  EarthStep step;
  step.dt_s = dt_s;
  step.C = Eigen::Matrix3d::Identity() + (1.0 + sinc_minus_one) * S + versin * S * S;
  step.origin_position_m = sinc_minus_one * turn_m + versin * phi.cross(turn_m);
  step.origin_velocity_mps =
      (1.0 + sinc_minus_one) * phi.cross(w_x_r0) + versin * phi.cross(phi.cross(w_x_r0));
  return step;
}

Eigen::Matrix3d GravitationGradient(const LocalFrame& frame, const Eigen::Vector3d& p_m) {
  constexpr double kStep_m = 500.0;
  Eigen::Matrix3d gradient;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d step = kStep_m * Eigen::Vector3d::Unit(axis);
    gradient.col(axis) =
        (frame.Gravitation(p_m + step) - frame.Gravitation(p_m - step)) / (2.0 * kStep_m);
  }
  return gradient;
}

Propagation::Propagation(const LocalFrame& frame, const MapPose& start,
                         const Eigen::Vector3d& added_mps2)
    : frame_(frame),
      start_(start),
      added_mps2_(added_mps2),
      G_begin_(frame.Gravitation(start.p_mb) + added_mps2) {}

MapPose Propagation::To(const InertialIncrements& increments) const {
  const double dt = increments.dt_s();
  const EarthStep earth = EarthStep::Make(frame_, dt);
  const Eigen::Vector3d& w = frame_.w_ie_m();
  const Eigen::Matrix3d C_inverse = earth.C.transpose();

  const Eigen::Vector3d predicted =
      C_inverse *
      (start_.p_mb + (start_.v_m + w.cross(start_.p_mb)) * dt - earth.origin_position_m +
       0.5 * dt * dt * G_begin_ + start_.q_mb * increments.delta_p);
  const Eigen::Vector3d G_end = frame_.Gravitation(predicted) + added_mps2_;

  MapPose end;
  end.t_s = increments.t_end_s;
  end.q_mb = (Eigen::Quaterniond(C_inverse) * start_.q_mb * increments.delta_q).normalized();
  end.p_mb = predicted + dt * dt / 6.0 * (G_end - C_inverse * G_begin_);
  end.v_m = C_inverse * (start_.v_m + w.cross(start_.p_mb) - earth.origin_velocity_mps +
                         0.5 * dt * G_begin_ + start_.q_mb * increments.delta_v) +
            0.5 * dt * G_end - w.cross(end.p_mb);
  return end;
}

MapPose Propagate(const LocalFrame& frame, const MapPose& start,
                  const InertialIncrements& increments, const Eigen::Vector3d& added_mps2) {
  return Propagation(frame, start, added_mps2).To(increments);
}

AffineStep AffineStep::Make(const LocalFrame& frame, double dt_s,
                            const Eigen::Vector3d& p_nominal_m) {
  const double dt = dt_s;
  const EarthStep earth = EarthStep::Make(frame, dt);
  const Eigen::Matrix3d C_inverse = earth.C.transpose();
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d W = Skew(frame.w_ie_m());
  const Eigen::Matrix3d Gamma = GravitationGradient(frame, p_nominal_m);
  const Eigen::Vector3d G_0 = frame.Gravitation(p_nominal_m) - Gamma * p_nominal_m;

  // Position predicted with the gravitation at the beginning, C^T z; Propagate has the same
  // iteration.
  const Eigen::Matrix3d z_p = I + dt * W + 0.5 * dt * dt * Gamma;
  const Eigen::Vector3d z_0 = -earth.origin_position_m + 0.5 * dt * dt * G_0;
  const Eigen::Vector3d G_end_0 = G_0 + Gamma * (C_inverse * z_0);
  const double k = dt * dt / 6.0;

  AffineStep step;
  step.C = earth.C;
  step.p_d = (I + k * Gamma) * C_inverse;
  step.p_p = step.p_d * z_p - k * C_inverse * Gamma;
  step.p_v = dt * step.p_d;
  step.p_0 = C_inverse * z_0 + k * (G_end_0 - C_inverse * G_0);

  const Eigen::Matrix3d half_Gamma = 0.5 * dt * Gamma * C_inverse;  // d (dt/2 G_end) / d z
  step.v_d = half_Gamma - W * step.p_d;
  step.v_p = C_inverse * (W + 0.5 * dt * Gamma) + half_Gamma * z_p - W * step.p_p;
  step.v_v = C_inverse + dt * half_Gamma - W * step.p_v;
  step.v_0 =
      C_inverse * (0.5 * dt * G_0 - earth.origin_velocity_mps) + 0.5 * dt * G_end_0 - W * step.p_0;
  return step;
}

}  // namespace dn
