#include <dn/error.h>
#include <dn/rotation.h>
#include <dn/sim/truth.h>

#include <cmath>
#include <utility>

#include "disturbance_table.h"
#include "platform_vibration.h"

namespace dn {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kSemiMajorAxis_m = 6378137.0;  // WGS84
constexpr double kFlattening = 1.0 / 298.257223563;
constexpr double kEccentricity2 = kFlattening * (2.0 - kFlattening);
constexpr double kEndsMargin_s = 1e-3;

/// Returns the transport rate: angular rate of the local north-east-down axes with respect to the
/// Earth, in these axes.
Vector3d TransportRate(const Matrix3d& R_en, const Vector3d& p_e, const Vector3d& v_n) {
  const Vector3d up_e = -R_en.col(2);
  const double sin_lat = up_e.z();
  const double cos_lat = std::hypot(up_e.x(), up_e.y());
  const double w = std::sqrt(1.0 - kEccentricity2 * sin_lat * sin_lat);
  const double h_m = p_e.dot(up_e) - kSemiMajorAxis_m * w;
  const double prime_vertical_m = kSemiMajorAxis_m / w + h_m;
  const double meridian_m = kSemiMajorAxis_m * (1.0 - kEccentricity2) / (w * w * w) + h_m;
  return {v_n.y() / prime_vertical_m, -v_n.x() / meridian_m,
          -v_n.y() / prime_vertical_m * sin_lat / cos_lat};
}

/// Returns the rotation from body to north-east-down: Rz(heading) Ry(pitch) Rx(roll).
Matrix3d BodyToNed(const Vector3d& rph) {
  const double cr = std::cos(rph.x()), sr = std::sin(rph.x());
  const double cp = std::cos(rph.y()), sp = std::sin(rph.y());
  const double ch = std::cos(rph.z()), sh = std::sin(rph.z());
  Matrix3d R;
  R << cp * ch, sr * sp * ch - cr * sh, cr * sp * ch + sr * sh,  //
      cp * sh, sr * sp * sh + cr * ch, cr * sp * sh - sr * ch,   //
      -sp, sr * cp, cr * cp;
  return R;
}

/// Returns the angular rate of the body with respect to north-east-down, in body, from the rates of
/// the angles.
Vector3d RateFromAngles(const Vector3d& rph, const Vector3d& rate) {
  const double cr = std::cos(rph.x()), sr = std::sin(rph.x());
  const double cp = std::cos(rph.y()), sp = std::sin(rph.y());
  return {rate.x() - rate.z() * sp, rate.y() * cr + rate.z() * cp * sr,
          -rate.y() * sr + rate.z() * cp * cr};
}

/// Returns the time derivative of RateFromAngles.
Vector3d AccelerationFromAngles(const Vector3d& rph, const Vector3d& rate, const Vector3d& accel) {
  const double cr = std::cos(rph.x()), sr = std::sin(rph.x());
  const double cp = std::cos(rph.y()), sp = std::sin(rph.y());
  const double pitch_rate = rate.y() * cr + rate.z() * cp * sr;
  const double yaw_rate = -rate.y() * sr + rate.z() * cp * cr;
  const Vector3d turning(-rate.z() * cp * rate.y(),
                         yaw_rate * rate.x() - rate.z() * sp * sr * rate.y(),
                         -pitch_rate * rate.x() - rate.z() * sp * cr * rate.y());
  return RateFromAngles(rph, accel) + turning;
}

}  // namespace

TruthTrajectory::TruthTrajectory(LocalFrame frame, UniformSpline path,
                                 const Disturbance& disturbance, double t_begin_s, double t_end_s,
                                 std::shared_ptr<const PlatformVibration> vibration)
    : frame_(std::move(frame)),
      path_(std::move(path)),
      vibration_(std::move(vibration)),
      t_begin_s_(t_begin_s),
      t_end_s_(t_end_s) {
  if (!(t_end_s_ > t_begin_s_)) throw InvalidInput("a trajectory must end after it begins");
  const double lead_s = disturbance.lead_s.Bound() + kEndsMargin_s;
  if (path_.t_begin_s() > -lead_s || path_.t_end_s() < t_end_s_ - t_begin_s_ + lead_s) {
    throw InvalidInput("the path does not cover the time span of the trajectory");
  }
  disturbance_ = std::make_shared<DisturbanceTable>(disturbance, t_end_s_ - t_begin_s_);
}

double TruthTrajectory::vibration_hz() const { return vibration_ ? vibration_->highest_hz() : 0.0; }

TruthTrajectory::Motion TruthTrajectory::MotionAt(double t_s) const {
  if (!(t_s >= t_begin_s_ - kEndsMargin_s && t_s <= t_end_s_ + kEndsMargin_s)) {
    throw InvalidInput("the time lies outside the simulated trajectory");
  }
  const double t = t_s - t_begin_s_;
  const DisturbanceTable::Sample air = disturbance_->At(t);
  const UniformSpline::Sample path = path_.At(t + air.value[0]);
  const double pace = 1.0 + air.first[0];

  Motion motion;
  motion.p = path.value.head<3>() + air.value[1] * Vector3d::UnitZ();
  motion.v = pace * path.first.head<3>() + air.first[1] * Vector3d::UnitZ();
  motion.a = pace * pace * path.second.head<3>() + air.second[0] * path.first.head<3>() +
             air.second[1] * Vector3d::UnitZ();
  motion.rph = path.value.tail<3>() + air.value.tail<3>();
  motion.rph_rate = pace * path.first.tail<3>() + air.first.tail<3>();
  motion.rph_accel = pace * pace * path.second.tail<3>() + air.second[0] * path.first.tail<3>() +
                     air.second.tail<3>();
  return motion;
}

MapPose TruthTrajectory::Pose(double t_s) const {
  if (vibration_) return State(t_s).pose;
  const Motion motion = MotionAt(t_s);
  MapPose pose;
  pose.t_s = t_s;
  pose.p_mb = motion.p;
  pose.v_m = motion.v;
  const Matrix3d R_mb = frame_.R_mn(motion.p) * BodyToNed(motion.rph);
  pose.q_mb = Eigen::Quaterniond(R_mb).normalized();
  return pose;
}

NormalEarth NormalEarth::At(const LocalFrame& frame, const Vector3d& p_m) {
  const Geodetic position = frame.ToGeodetic(p_m);
  return {p_m, position, frame.R_me() * R_en(position), frame.Gravitation(p_m)};
}

TruthState TruthTrajectory::State(double t_s) const {
  NormalEarth earth;
  return State(t_s, &earth);
}

TruthState TruthTrajectory::State(double t_s, NormalEarth* earth) const {
  const Motion motion = MotionAt(t_s);
  *earth = NormalEarth::At(frame_, motion.p);
  return ComputeState(motion, t_s, earth->R_mn, earth->gravitation_m);
}

TruthState TruthTrajectory::StateBetween(const NormalEarth& a, const NormalEarth& b,
                                         double t_s) const {
  const Motion motion = MotionAt(t_s);
  const Vector3d way_m = b.p_m - a.p_m;
  const double length2_m2 = way_m.squaredNorm();
  const double share = length2_m2 > 0.0 ? way_m.dot(motion.p - a.p_m) / length2_m2 : 0.0;
  return ComputeState(motion, t_s, a.R_mn + share * (b.R_mn - a.R_mn),
                      a.gravitation_m + share * (b.gravitation_m - a.gravitation_m));
}

TruthState TruthTrajectory::ComputeState(const Motion& motion, double t_s, const Matrix3d& R_mn,
                                         const Vector3d& gravitation_m) const {
  const Matrix3d R_nb = BodyToNed(motion.rph);
  Matrix3d R_mb = R_mn * R_nb;
  Vector3d r_m = frame_.r0_m() + motion.p;
  const Vector3d& w = frame_.w_ie_m();

  TruthState state;
  state.pose.t_s = t_s;
  state.pose.p_mb = motion.p;
  state.pose.v_m = motion.v;
  state.pose.q_mb = Eigen::Quaterniond(R_mb).normalized();
  state.a_m = motion.a;
  const Vector3d w_en_n =
      TransportRate(frame_.R_me().transpose() * R_mn, frame_.R_me().transpose() * r_m,
                    R_mn.transpose() * motion.v);
  state.w_mb_b = R_nb.transpose() * w_en_n + RateFromAngles(motion.rph, motion.rph_rate);
  if (vibration_) {
    Shake(motion, &state);
    R_mb = state.pose.q_mb.toRotationMatrix();
    r_m = frame_.r0_m() + state.pose.p_mb;
  }
  state.w_ib_b = R_mb.transpose() * w + state.w_mb_b;
  state.f_b = R_mb.transpose() *
              (state.a_m + 2.0 * w.cross(state.pose.v_m) + w.cross(w.cross(r_m)) - gravitation_m);
  return state;
}

void TruthTrajectory::Shake(const Motion& motion, TruthState* state) const {
  const PlatformVibration::Sample shake = vibration_->At(state->pose.t_s - t_begin_s_);
  const Eigen::Quaterniond q_mb = state->pose.q_mb;
  const Vector3d& w = state->w_mb_b;
  // The change of the transport rate is negligible: 1e-6 rad/s^2 times the displacement.
  const Vector3d w_rate = AccelerationFromAngles(motion.rph, motion.rph_rate, motion.rph_accel);
  state->pose.p_mb += q_mb * shake.shift;
  state->pose.v_m += q_mb * (w.cross(shake.shift) + shake.shift_rate);
  state->a_m += q_mb * (w.cross(w.cross(shake.shift)) + w_rate.cross(shake.shift) +
                        2.0 * w.cross(shake.shift_rate) + shake.shift_accel);
  const Eigen::Quaterniond q_turn = Exp<double>(shake.turn);
  state->pose.q_mb = (q_mb * q_turn).normalized();
  state->w_mb_b = q_turn.conjugate() * w + RightJacobian(shake.turn) * shake.turn_rate;
}

NavPoint TruthTrajectory::Nav(double t_s) const {
  NormalEarth earth;
  const TruthState state = State(t_s, &earth);
  return ToNavPoint(state, earth);
}

NavPoint ToNavPoint(const TruthState& state, const NormalEarth& earth) {
  NavPoint point;
  point.t_s = state.pose.t_s;
  point.position = earth.position;
  point.q_nb =
      (Eigen::Quaterniond(Matrix3d(earth.R_mn.transpose())) * state.pose.q_mb).normalized();
  point.v_ned_mps = earth.R_mn.transpose() * state.pose.v_m;
  point.f_b_mps2 = state.f_b;
  point.w_b_radps = state.w_ib_b;
  return point;
}

}  // namespace dn
