#include <dn/error.h>
#include <dn/imu/preintegration.h>
#include <dn/rotation.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "bridge_cursor.h"

namespace dn {
// Members of the Impl classes have these types, so they are not in an unnamed namespace.
namespace imu_internal {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Part of one sample with rates that are linear in time: x(t) = mean + slope (t - middle).
struct Piece {
  double dt_s;
  Vector3d w, w_slope, f, f_slope;
};

/// White noise densities, rad^2/s and m^2/s^3.
struct Densities {
  double gyro = 0.0, accel = 0.0;

  friend Densities operator+(const Densities& a, const Densities& b) {
    return {a.gyro + b.gyro, a.accel + b.accel};
  }
};

/// Returns the density that vibration adds to the white noise of a sample.
Densities VibrationNoise(const std::vector<ImuVibration>& vibration, const ImuSample& sample) {
  Densities sum;
  for (const ImuVibration& v : vibration) {
    if (!v.Covers(sample.t_s)) continue;
    sum = sum + Densities{v.gyro_sigma_radps * v.gyro_sigma_radps * sample.dt_s,
                          v.accel_sigma_mps2 * v.accel_sigma_mps2 * sample.dt_s};
  }
  return sum;
}

/// Returns the density that a bridge adds to the white noise of its sample: the error of the hole,
/// spread over the whole sample. nullptr: the sample has no bridge.
Densities BridgeNoise(const ImuBridge* bridge, double dt_s) {
  if (bridge == nullptr) return {};
  return {bridge->gyro_sigma_rad * bridge->gyro_sigma_rad / dt_s,
          bridge->accel_sigma_mps * bridge->accel_sigma_mps / dt_s};
}

std::string Seconds(double t_s) {
  char text[40];
  std::snprintf(text, sizeof text, "%.6f s", t_s);
  return text;
}

double Middle(const ImuSample& sample) { return sample.t_s - 0.5 * sample.dt_s; }

/// Rates of a sample without biases, as a linear function of time. It has the mean of the sample
/// and the slope that reproduces the first moment.
class LinearSample {
 public:
  LinearSample(const ImuData& imu, std::size_t k, const ImuCorrection& bias)
      : middle_s_(Middle(imu.samples[k])),
        w_(imu.samples[k].w_ib_b_radps - bias.gyro_bias_radps),
        f_(imu.samples[k].f_b_mps2 - bias.accel_bias_mps2) {
    const std::vector<ImuSample>& x = imu.samples;
    const std::size_t a = Before(x, k), b = After(x, k);
    if (a == b) return;
    const std::size_t aa = Before(x, a), bb = After(x, b);
    if (a == k || b == k || aa == a || bb == b) {
      AddSlope(x[a], x[b], 1.0);
    } else {
      AddSlope(x[a], x[b], kNearWeight);
      AddSlope(x[aa], x[bb], 1.0 - kNearWeight);
    }
  }

  Vector3d Rate(double t_s) const { return w_ + (t_s - middle_s_) * w_slope_; }
  Vector3d Force(double t_s) const { return f_ + (t_s - middle_s_) * f_slope_; }

  /// Returns the part of the sample in [t0_s, t1_s].
  Piece Part(double t0_s, double t1_s) const {
    const double middle_s = t0_s + 0.5 * (t1_s - t0_s);
    return {t1_s - t0_s, Rate(middle_s), w_slope_, Force(middle_s), f_slope_};
  }

 private:
  // A signal x has means x + h^2/24 x'' over samples of length h. Differences of means at distances
  // 1 and 2 therefore give the slopes x' + 5/24 h^2 x''' and x' + 17/24 h^2 x'''. The line with the
  // same first moment has slope x' + 1/40 h^2 x'''. It is the mean of both slopes with weights w
  // and 1 - w.
  static constexpr double kNearWeight = 41.0 / 30.0;

  static std::size_t Before(const std::vector<ImuSample>& x, std::size_t k) {
    return k > 0 && Adjoin(x[k - 1], x[k]) ? k - 1 : k;
  }
  static std::size_t After(const std::vector<ImuSample>& x, std::size_t k) {
    return k + 1 < x.size() && Adjoin(x[k], x[k + 1]) ? k + 1 : k;
  }
  void AddSlope(const ImuSample& a, const ImuSample& b, double weight) {
    const double rate = weight / (Middle(b) - Middle(a));
    w_slope_ += rate * (b.w_ib_b_radps - a.w_ib_b_radps);
    f_slope_ += rate * (b.f_b_mps2 - a.f_b_mps2);
  }

  double middle_s_;
  Vector3d w_, f_;
  Vector3d w_slope_ = Vector3d::Zero(), f_slope_ = Vector3d::Zero();
};

/// Removes the effects of a correction from pieces after the biases are subtracted.
class EffectCorrector {
 public:
  explicit EffectCorrector(const ImuEffectValues& effects) : effects_(effects) {
    for (const ImuEffectValue& one : effects) Check(one);
    const Eigen::Index columns = kBiases + TotalComponents(effects);
    reading_.J_w.resize(3, columns);
    reading_.J_f.resize(3, columns);
  }

  bool empty() const { return effects_.empty(); }

  /// Corrects the piece at t_s. The derivatives of the result remain in reading().
  void Correct(double t_s, Piece* piece) {
    reading_.t_s = t_s;
    reading_.w_b = piece->w;
    reading_.f_b = piece->f;
    reading_.J_w.setZero();
    reading_.J_f.setZero();
    reading_.J_w.leftCols<3>().diagonal().setConstant(-1.0);
    reading_.J_f.middleCols<3>(3).diagonal().setConstant(-1.0);
    Eigen::Index column = kBiases;
    for (const ImuEffectValue& one : effects_) {
      one.effect->Correct(one.value, column, &reading_);
      column += one.value.size();
    }
    Eigen::Matrix<double, kBiases, 1> slope;
    slope << piece->w_slope, piece->f_slope;
    piece->w = reading_.w_b;
    piece->f = reading_.f_b;
    piece->w_slope = -reading_.J_w.leftCols<kBiases>() * slope;
    piece->f_slope = -reading_.J_f.leftCols<kBiases>() * slope;
  }

  const ImuReading& reading() const { return reading_; }

  static constexpr int kBiases = 6;  // number of bias columns, which precede those of the effects

 private:
  static void Check(const ImuEffectValue& one) {
    if (one.value.size() == one.effect->components() && one.value.allFinite()) return;
    throw InvalidInput("the value of an effect of the inertial sensors needs " +
                       std::to_string(one.effect->components()) + " finite values");
  }

  const ImuEffectValues& effects_;
  ImuReading reading_;
};

/// Functions of the angle x in the exponential and in its integrals:
///   half_sinc = sin(x/2)/x, cos_half = cos(x/2),
///   a = (1 - cos x)/x^2, b = (x - sin x)/x^3, c = (x^2/2 + cos x - 1)/x^4.
struct AngleFunctions {
  double half_sinc, cos_half, a, b, c;

  explicit AngleFunctions(double x2) {
    if (x2 < 1e-2) {  // series; the first neglected term is below 1e-16
      half_sinc = 0.5 - x2 * (1.0 / 48 - x2 * (1.0 / 3840 - x2 * (1.0 / 645120 - x2 / 185794560)));
      cos_half = 1.0 - x2 * (1.0 / 8 - x2 * (1.0 / 384 - x2 * (1.0 / 46080 - x2 / 10321920)));
      a = 0.5 - x2 * (1.0 / 24 - x2 * (1.0 / 720 - x2 * (1.0 / 40320 - x2 / 3628800)));
      b = 1.0 / 6 - x2 * (1.0 / 120 - x2 * (1.0 / 5040 - x2 * (1.0 / 362880 - x2 / 39916800)));
      c = 1.0 / 24 - x2 * (1.0 / 720 - x2 * (1.0 / 40320 - x2 * (1.0 / 3628800 - x2 / 479001600)));
      return;
    }
    const double x = std::sqrt(x2);
    half_sinc = std::sin(0.5 * x) / x;
    cos_half = std::cos(0.5 * x);
    a = 2.0 * half_sinc * half_sinc;
    b = (1.0 - std::sin(x) / x) / x2;
    c = (0.5 - a) / x2;
  }
};

/// Returns a x M, column by column.
Matrix3d Cross(const Vector3d& a, const Matrix3d& M) {
  Matrix3d out;
  for (int i = 0; i < 3; ++i) out.col(i) = a.cross(M.col(i));
  return out;
}

/// Returns Skew(a) Skew(b).
Matrix3d SkewProduct(const Vector3d& a, const Vector3d& b) {
  Matrix3d out = b * a.transpose();
  out.diagonal().array() -= a.dot(b);
  return out;
}

/// Contribution of one piece to the increments before it.
struct PieceMotion {
  Matrix3d dR;  ///< rotation from body at the beginning of the piece to body at the beginning
  Vector3d phi_b;
  AngleFunctions g;
  Vector3d phi, u;  ///< rotation, and velocity change without rotation, in axes at the beginning
  Vector3d velocity, position;  ///< added to the increments
};

/// Integrates rotation, velocity and position piece by piece.
class MotionIntegrator {
 public:
  PieceMotion Move(const Piece& piece) const {
    const double d = piece.dt_s;
    const double d3 = d * d * d / 12.0;
    const Matrix3d dR = dq_.toRotationMatrix();

    // Coning by the Magnus expansion to second order: a slope s of the rate adds d^3/12 w x s.
    const Vector3d phi_b = d * piece.w + d3 * piece.w.cross(piece.w_slope);
    const AngleFunctions g(phi_b.squaredNorm());
    const Vector3d phi = dR * phi_b;
    const Vector3d u = dR * (d * piece.f);
    const Vector3d phi_x_u = phi.cross(u);
    const Vector3d phi_x_phi_x_u = phi.cross(phi_x_u);
    const Vector3d f_x_slope = dR * piece.f.cross(piece.w_slope);
    // Sculling and scrolling: the integral of R f and its integral, with R and f linear in time.
    const Vector3d velocity = u + g.a * phi_x_u + g.b * phi_x_phi_x_u +
                              d3 * (dR * piece.w.cross(piece.f_slope) + f_x_slope);
    const Vector3d position = d * (0.5 * u + g.b * phi_x_u + g.c * phi_x_phi_x_u) -
                              d3 * (dR * piece.f_slope - 0.5 * d * f_x_slope);
    return {dR, phi_b, g, phi, u, velocity, position};
  }

  void Add(double dt_s, const PieceMotion& motion) {
    dp_ += dt_s * dv_ + motion.position;
    dv_ += motion.velocity;
    const AngleFunctions& g = motion.g;
    const Vector3d& phi_b = motion.phi_b;
    dq_ = dq_ * Eigen::Quaterniond(g.cos_half, g.half_sinc * phi_b.x(), g.half_sinc * phi_b.y(),
                                   g.half_sinc * phi_b.z());
    dq_.coeffs() *= 1.5 - 0.5 * dq_.squaredNorm();  // renormalises to within rounding
  }

  void Add(const Piece& piece) { Add(piece.dt_s, Move(piece)); }

  void Write(InertialIncrements* out) const {
    out->delta_q = dq_.normalized();
    out->delta_v = dv_;
    out->delta_p = dp_;
  }

  const Vector3d& dv() const { return dv_; }
  const Vector3d& dp() const { return dp_; }

 private:
  Eigen::Quaterniond dq_ = Eigen::Quaterniond::Identity();
  Vector3d dv_ = Vector3d::Zero(), dp_ = Vector3d::Zero();
};

/// Integrates covariance and derivatives piece by piece. Rotation errors are rotation vectors psi
/// in body axes at the beginning (true dR = Exp(psi) dR). White gyro noise then makes psi
/// isotropic, and its correlations with velocity and position are skew-symmetric. Therefore the
/// 9 x 9 recursion P <- F P F^T + Q reduces to vectors and rank-two terms:
///   E[psi psi^T] = P_qq I,  E[dv psi^T] = -[a]x,  E[dp psi^T] = -[b]x.
class Integrator {
 public:
  explicit Integrator(const PreintegrationNoise& noise)
      : gyro_psd_(noise.gyro_white_rad_per_sqrt_s * noise.gyro_white_rad_per_sqrt_s),
        accel_psd_(noise.accel_white_mps_per_sqrt_s * noise.accel_white_mps_per_sqrt_s) {}

  /// Adds a piece. `added`: noise in addition to the white noise of the sensor. `reading`:
  /// derivatives of the rates with respect to biases and effects; nullptr without effects.
  void Add(const Piece& piece, const Densities& added, const ImuReading* reading) {
    const double d = piece.dt_s;
    const PieceMotion motion = motion_.Move(piece);
    const Densities psd{gyro_psd_ + added.gyro, accel_psd_ + added.accel};
    noisy_ = noisy_ || psd.gyro > 0.0 || psd.accel > 0.0;
    if (noisy_) AddCovariance(d, psd, motion);
    AddBiasJacobians(d, motion, reading);
    motion_.Add(d, motion);
    t_s_ += d;
  }

  void Write(Preintegrated* out) const {
    motion_.Write(out);
    const Matrix3d dR = out->delta_q.toRotationMatrix();
    const Matrix3d dR_inverse = dR.transpose();

    // The covariance changes from psi in body axes at the beginning to a rotation vector at the
    // end.
    const Matrix3d P_vq = -Skew(a_) * dR;
    const Matrix3d P_pq = -Skew(b_) * dR;
    out->covariance << P_qq_ * Matrix3d::Identity(), P_vq.transpose(), P_pq.transpose(), P_vq,
        P_vv_, P_pv_.transpose(), P_pq, P_pv_, P_pp_;
    if (sums_.cols() > 0) {
      WriteSensitivities(dR_inverse, out);
      return;
    }
    out->J_q_bg = dR_inverse * bias_.q;
    out->J_v_bg = bias_.v;
    out->J_p_bg = bias_.p;
    out->J_v_ba = J_v_ba_;
    out->J_p_ba = J_p_ba_;
  }

 private:
  struct Sensitivity {
    Matrix3d q = Matrix3d::Zero(), v = Matrix3d::Zero(), p = Matrix3d::Zero();
  };

  // The noise within the piece is continuous and white. Its moments are exact for a constant
  // specific force, so that the covariance is positive semidefinite and independent of the
  // sampling.
  void AddCovariance(double d, const Densities& psd, const PieceMotion& motion) {
    const Vector3d &u = motion.u, &velocity = motion.velocity, &position = motion.position;
    const double psi_psd = P_qq_, q = psd.gyro * d;
    const Vector3d c = b_ + d * a_;
    const Matrix3d uu = SkewProduct(u, u);
    const Matrix3d a_velocity = SkewProduct(a_, velocity);
    const Matrix3d c_position = SkewProduct(c, position);
    const Matrix3d P_pv_moved = P_pv_ + d * P_vv_;

    P_pp_ += d * (P_pv_moved + P_pv_.transpose()) - c_position - c_position.transpose() -
             psi_psd * SkewProduct(position, position) - q * d * d / 20.0 * uu;
    P_pp_.diagonal().array() += psd.accel * d * d * d / 3.0;
    P_pv_ = P_pv_moved - SkewProduct(position, a_) - SkewProduct(c, velocity) -
            psi_psd * SkewProduct(position, velocity) - q * d / 8.0 * uu;
    P_pv_.diagonal().array() += psd.accel * d * d / 2.0;
    P_vv_ += -a_velocity - a_velocity.transpose() - psi_psd * SkewProduct(velocity, velocity) -
             q / 3.0 * uu;
    P_vv_.diagonal().array() += psd.accel * d;
    b_ = c + psi_psd * position + q * d / 6.0 * u;
    a_ += psi_psd * velocity + 0.5 * q * u;
    P_qq_ += q;
  }

  void AddBiasJacobians(double d, const PieceMotion& motion, const ImuReading* reading) {
    const Matrix3d& dR = motion.dR;
    const AngleFunctions& g = motion.g;
    const Vector3d &velocity = motion.velocity, &position = motion.position;
    const Matrix3d phi_x_dR = Cross(motion.phi, dR);
    const Matrix3d phi_x_phi_x_dR = Cross(motion.phi, phi_x_dR);
    const Matrix3d turned = dR + g.a * phi_x_dR + g.b * phi_x_phi_x_dR;  // left Jacobian times dR
    const Matrix3d moved = 0.5 * dR + g.b * phi_x_dR + g.c * phi_x_phi_x_dR;
    const Matrix3d u_x_dR = Cross(motion.u, dR);
    if (reading != nullptr) {
      AddSensitivities(d, turned, moved, u_x_dR, velocity, position, *reading);
      return;
    }
    J_p_ba_ += d * J_v_ba_ - d * d * moved;
    J_v_ba_ -= d * turned;
    // The terms within the piece (u) are of first order in its rotation.
    bias_.p += d * bias_.v - Cross(position, bias_.q) + d * d / 6.0 * u_x_dR;
    bias_.v += 0.5 * d * u_x_dR - Cross(velocity, bias_.q);
    bias_.q -= d * turned;
  }

  // Adds the derivatives with respect to any parameters on which rate and specific force depend.
  // The influence of a rate change on velocity and position increases with the later increments.
  // Let V, P be the increments up to the end of this piece, and t its time. The sums
  //   q = sum dq,  b = sum dv + V x dq,  a = sum dp - t (dv + V x dq) + P x dq
  // over the changes within the pieces are then sufficient for every later end T:
  //   v = b - V(T) x q,  p = a + T b - P(T) x q.
  void AddSensitivities(double d, const Matrix3d& turned, const Matrix3d& moved,
                        const Matrix3d& u_x_dR, const Vector3d& velocity, const Vector3d& position,
                        const ImuReading& reading) {
    if (sums_.cols() == 0) sums_.setZero(9, reading.J_w.cols());
    const Vector3d V = motion_.dv() + velocity, P = motion_.dp() + d * motion_.dv() + position;
    const double t = t_s_ + d;
    Eigen::Matrix<double, 9, 3> of_w, of_f;
    of_w.topRows<3>() = d * turned;
    of_w.middleRows<3>(3) = Cross(V, of_w.topRows<3>()) - 0.5 * d * u_x_dR;
    of_w.bottomRows<3>() =
        Cross(P, of_w.topRows<3>()) - d * d / 6.0 * u_x_dR - t * of_w.middleRows<3>(3);
    of_f.topRows<3>().setZero();
    of_f.middleRows<3>(3) = d * turned;
    of_f.bottomRows<3>() = d * d * moved - t * of_f.middleRows<3>(3);
    for (Eigen::Index c = 0; c < reading.J_w.cols(); ++c) {
      const double* w = reading.J_w.col(c).data();
      const double* f = reading.J_f.col(c).data();
      // Most derivatives concern one axis only.
      for (int axis = 0; axis < 3; ++axis) {
        if (w[axis] != 0.0) sums_.col(c) += w[axis] * of_w.col(axis);
        if (f[axis] != 0.0) sums_.col(c).tail<6>() += f[axis] * of_f.col(axis).tail<6>();
      }
    }
  }

  void WriteSensitivities(const Matrix3d& dR_inverse, Preintegrated* out) const {
    Eigen::Matrix<double, 9, Eigen::Dynamic> K = sums_;
    for (Eigen::Index c = 0; c < K.cols(); ++c) {
      const Vector3d q = sums_.col(c).head<3>(), b = sums_.col(c).segment<3>(3);
      K.col(c).head<3>() = dR_inverse * q;
      K.col(c).segment<3>(3) -= motion_.dv().cross(q);
      K.col(c).tail<3>() += t_s_ * b - motion_.dp().cross(q);
    }
    out->J_q_bg = K.topLeftCorner<3, 3>();
    out->J_v_bg = K.block<3, 3>(3, 0);
    out->J_p_bg = K.bottomLeftCorner<3, 3>();
    out->J_v_ba = K.block<3, 3>(3, 3);
    out->J_p_ba = K.block<3, 3>(6, 3);
    out->J_effects = K.rightCols(K.cols() - EffectCorrector::kBiases);
  }

  double gyro_psd_, accel_psd_;
  bool noisy_ = false;
  double P_qq_ = 0.0;  // variance of each component of psi
  MotionIntegrator motion_;
  Vector3d a_ = Vector3d::Zero(), b_ = Vector3d::Zero();
  Matrix3d P_vv_ = Matrix3d::Zero(), P_pv_ = Matrix3d::Zero(), P_pp_ = Matrix3d::Zero();
  Sensitivity bias_;
  Matrix3d J_v_ba_ = Matrix3d::Zero(), J_p_ba_ = Matrix3d::Zero();
  double t_s_ = 0.0;  // time since the beginning
  // Sums of AddSensitivities for biases and effects; empty without effects.
  Eigen::Matrix<double, 9, Eigen::Dynamic> sums_;
};

void CheckBias(const ImuCorrection& bias, double t_s) {
  const bool gyro = bias.gyro_bias_radps.allFinite();
  if (gyro && bias.accel_bias_mps2.allFinite()) return;
  throw InvalidInput(
      "the estimated bias of the " + std::string(gyro ? "accelerometers" : "gyros") +
      " at t = " + Seconds(t_s) +
      " is not finite: the adjustment diverges; check units and axes of the inertial "
      "data, and the sigmas of the biases and of GNSS");
}

void CheckNoise(double value) {
  if (!(value >= 0.0) || !std::isfinite(value)) {
    throw InvalidInput("inertial increments: a noise is " + std::to_string(value) +
                       ", but must be finite and not negative");
  }
}

void CheckNoise(const PreintegrationNoise& noise) {
  CheckNoise(noise.gyro_white_rad_per_sqrt_s);
  CheckNoise(noise.accel_white_mps_per_sqrt_s);
  CheckNoise(noise.position_floor_m);
  for (const ImuVibration& vibration : noise.vibration) {
    CheckNoise(vibration.gyro_sigma_radps);
    CheckNoise(vibration.accel_sigma_mps2);
  }
}

void CheckInside(const ImuData& imu, double t0_s, double t1_s) {
  if (imu.samples.empty()) throw InvalidInput("inertial increments: there are no IMU data");
  if (!(t0_s >= imu.t_begin_s() - kImuTimeTolerance_s) ||
      !(t1_s <= imu.t_end_s() + kImuTimeTolerance_s)) {
    throw InvalidInput("inertial increments from " + Seconds(t0_s) + " to " + Seconds(t1_s) +
                       ": the IMU data cover " + Seconds(imu.t_begin_s()) + " to " +
                       Seconds(imu.t_end_s()));
  }
}

[[noreturn]] void ThrowGap(double t0_s, double t1_s, const ImuSample& after) {
  throw InvalidInput("inertial increments from " + Seconds(t0_s) + " to " + Seconds(t1_s) +
                     ": the IMU data have a gap that ends at " + Seconds(after.t_s - after.dt_s));
}

void WriteEnd(const LinearSample& sample, EffectCorrector* corrector, InertialIncrements* out) {
  Piece end = sample.Part(out->t_end_s, out->t_end_s);
  if (!corrector->empty()) corrector->Correct(out->t_end_s, &end);
  out->w_end_b_radps = end.w;
  out->f_end_b_mps2 = end.f;
}

Preintegrated LinearisedAt(const ImuCorrection& correction) {
  Preintegrated out;
  out.linearisation = correction;
  out.J_effects.setZero(9, TotalComponents(correction.effects));
  return out;
}

/// Visits the samples from t_begin_s on, piece by piece. The requested ends must come in increasing
/// order.
class SampleWalk {
 public:
  SampleWalk(const ImuData& imu, double t_begin_s, const ImuCorrection& correction)
      : imu_(imu),
        t_begin_s_(t_begin_s),
        correction_(correction),
        corrector_(correction_.effects),
        t_s_(t_begin_s),
        last_end_s_(t_begin_s) {
    CheckBias(correction, t_begin_s);
  }

  /// Calls each(piece) for all samples that end before t_end_s.
  template <class Each>
  void Pass(double t_end_s, const Each& each) {
    Check(t_end_s);
    last_end_s_ = t_end_s;
    if (!k_) {
      k_ = std::min(SampleRange(imu_, t_begin_s_, t_end_s).first, imu_.samples.size() - 1);
    }
    for (; imu_.samples[*k_].t_s < t_end_s && *k_ + 1 < imu_.samples.size(); ++*k_) {
      const double stop_s = imu_.samples[*k_].t_s;
      each(Rest(Linear(t_end_s), stop_s));
      t_s_ = stop_s;
    }
  }

  /// Calls each(piece) for the last piece, which stays the next one to visit. Call it after Pass.
  template <class Each>
  void Finish(double t_end_s, const Each& each, InertialIncrements* out) {
    const LinearSample linear = Linear(t_end_s);
    each(Rest(linear, t_end_s));
    out->t_begin_s = t_begin_s_;
    out->t_end_s = t_end_s;
    WriteEnd(linear, &corrector_, out);
  }

  const ImuSample& sample() const { return imu_.samples[*k_]; }
  const ImuCorrection& correction() const { return correction_; }
  /// Derivatives of the rates of the current piece with respect to biases and effects; nullptr
  /// without effects.
  const ImuReading* reading() const { return corrector_.empty() ? nullptr : &corrector_.reading(); }

 private:
  void Check(double t_end_s) const {
    if (!(t_end_s > t_begin_s_)) {
      throw InvalidInput("inertial increments: the end " + Seconds(t_end_s) +
                         " is not after the beginning " + Seconds(t_begin_s_));
    }
    if (t_end_s < last_end_s_) {
      throw InvalidInput("inertial increments: the end " + Seconds(t_end_s) +
                         " precedes the previous end " + Seconds(last_end_s_));
    }
    CheckInside(imu_, t_begin_s_, t_end_s);
  }

  LinearSample Linear(double t_end_s) const {
    if (sample().t_s - sample().dt_s > t_s_ + kImuTimeTolerance_s) {
      ThrowGap(t_begin_s_, t_end_s, sample());
    }
    return {imu_, *k_, correction_};
  }

  /// Returns the remaining part of the current sample, up to stop_s.
  Piece Rest(const LinearSample& linear, double stop_s) {
    Piece piece = linear.Part(t_s_, stop_s);
    if (!corrector_.empty()) corrector_.Correct(t_s_ + 0.5 * (stop_s - t_s_), &piece);
    return piece;
  }

  const ImuData& imu_;
  double t_begin_s_;
  ImuCorrection correction_;
  EffectCorrector corrector_;
  std::optional<std::size_t> k_;  ///< index of the next sample
  double t_s_;                    ///< end of the visited time
  double last_end_s_;             ///< t_end_s of the last Pass
};

}  // namespace imu_internal

class IncrementalPreintegrator::Impl {
 public:
  Impl(const ImuData& imu, double t_begin_s, const ImuCorrection& correction,
       const PreintegrationNoise& noise)
      : noise_(noise),
        walk_(imu, t_begin_s, correction),
        integrator_(noise),
        bridges_(imu, t_begin_s) {
    imu_internal::CheckNoise(noise);
  }

  Preintegrated To(double t_end_s) {
    walk_.Pass(t_end_s, [&](const imu_internal::Piece& piece) { Add(piece, &integrator_); });
    imu_internal::Integrator whole = integrator_;
    Preintegrated out = imu_internal::LinearisedAt(walk_.correction());
    walk_.Finish(
        t_end_s, [&](const imu_internal::Piece& piece) { Add(piece, &whole); }, &out);
    whole.Write(&out);
    out.covariance.bottomRightCorner<3, 3>().diagonal().array() +=
        noise_.position_floor_m * noise_.position_floor_m;
    return out;
  }

 private:
  void Add(const imu_internal::Piece& piece, imu_internal::Integrator* integrator) {
    const ImuSample& sample = walk_.sample();
    integrator->Add(piece,
                    imu_internal::BridgeNoise(bridges_.Find(sample), sample.dt_s) +
                        imu_internal::VibrationNoise(noise_.vibration, sample),
                    walk_.reading());
  }

  const PreintegrationNoise& noise_;
  imu_internal::SampleWalk walk_;
  imu_internal::Integrator integrator_;
  imu_internal::BridgeCursor bridges_;
};

class IncrementalMotionIntegrator::Impl {
 public:
  Impl(const ImuData& imu, double t_begin_s, const ImuCorrection& correction)
      : walk_(imu, t_begin_s, correction) {}

  InertialIncrements To(double t_end_s) {
    walk_.Pass(t_end_s, [&](const imu_internal::Piece& piece) { integrator_.Add(piece); });
    imu_internal::MotionIntegrator whole = integrator_;
    InertialIncrements out;
    walk_.Finish(
        t_end_s, [&](const imu_internal::Piece& piece) { whole.Add(piece); }, &out);
    whole.Write(&out);
    return out;
  }

 private:
  imu_internal::SampleWalk walk_;
  imu_internal::MotionIntegrator integrator_;
};

IncrementalPreintegrator::IncrementalPreintegrator(const ImuData& imu, double t_begin_s,
                                                   const ImuCorrection& correction,
                                                   const PreintegrationNoise& noise)
    : impl_(std::make_unique<Impl>(imu, t_begin_s, correction, noise)) {}

IncrementalPreintegrator::~IncrementalPreintegrator() = default;

Preintegrated IncrementalPreintegrator::To(double t_end_s) { return impl_->To(t_end_s); }

Preintegrated Preintegrate(const ImuData& imu, double t_begin_s, double t_end_s,
                           const ImuCorrection& correction, const PreintegrationNoise& noise) {
  return IncrementalPreintegrator(imu, t_begin_s, correction, noise).To(t_end_s);
}

IncrementalMotionIntegrator::IncrementalMotionIntegrator(const ImuData& imu, double t_begin_s,
                                                         const ImuCorrection& correction)
    : impl_(std::make_unique<Impl>(imu, t_begin_s, correction)) {}

IncrementalMotionIntegrator::~IncrementalMotionIntegrator() = default;

InertialIncrements IncrementalMotionIntegrator::To(double t_end_s) { return impl_->To(t_end_s); }

InertialIncrements IntegrateMotion(const ImuData& imu, double t_begin_s, double t_end_s,
                                   const ImuCorrection& correction) {
  return IncrementalMotionIntegrator(imu, t_begin_s, correction).To(t_end_s);
}

Preintegrated IdentityIncrement(const ImuData& imu, double t_s, const ImuCorrection& correction) {
  imu_internal::CheckInside(imu, t_s, t_s);
  imu_internal::CheckBias(correction, t_s);
  const auto after =
      std::lower_bound(imu.samples.begin(), imu.samples.end(), t_s - kImuTimeTolerance_s,
                       [](const ImuSample& sample, double t) { return sample.t_s < t; });
  if (after->t_s - after->dt_s > t_s + kImuTimeTolerance_s)
    imu_internal::ThrowGap(t_s, t_s, *after);
  Preintegrated out = imu_internal::LinearisedAt(correction);
  out.t_begin_s = out.t_end_s = t_s;
  imu_internal::EffectCorrector corrector(correction.effects);
  imu_internal::WriteEnd(
      imu_internal::LinearSample(imu, static_cast<std::size_t>(after - imu.samples.begin()),
                                 correction),
      &corrector, &out);
  return out;
}

Preintegrated Compose(const Preintegrated& a, const Preintegrated& b) {
  const double dt = b.dt_s();
  const Eigen::Matrix3d A = a.delta_q.toRotationMatrix();
  const Eigen::Matrix3d B_inverse = b.delta_q.toRotationMatrix().transpose();
  const Eigen::Matrix3d A_v = A * Skew(b.delta_v), A_p = A * Skew(b.delta_p);

  Preintegrated out = b;
  out.t_begin_s = a.t_begin_s;
  out.delta_q = (a.delta_q * b.delta_q).normalized();
  out.delta_v = a.delta_v + A * b.delta_v;
  out.delta_p = a.delta_p + a.delta_v * dt + A * b.delta_p;

  Eigen::Matrix<double, 9, 9> F = Eigen::Matrix<double, 9, 9>::Identity();
  F.block<3, 3>(0, 0) = B_inverse;
  F.block<3, 3>(3, 0) = -A_v;
  F.block<3, 3>(6, 0) = -A_p;
  F.block<3, 3>(6, 3) = dt * Eigen::Matrix3d::Identity();
  Eigen::Matrix<double, 9, 9> G = Eigen::Matrix<double, 9, 9>::Identity();
  G.block<3, 3>(3, 3) = A;
  G.block<3, 3>(6, 6) = A;
  out.covariance = F * a.covariance * F.transpose() + G * b.covariance * G.transpose();

  out.J_q_bg = B_inverse * a.J_q_bg + b.J_q_bg;
  out.J_v_bg = a.J_v_bg - A_v * a.J_q_bg + A * b.J_v_bg;
  out.J_p_bg = a.J_p_bg + dt * a.J_v_bg - A_p * a.J_q_bg + A * b.J_p_bg;
  out.J_v_ba = a.J_v_ba + A * b.J_v_ba;
  out.J_p_ba = a.J_p_ba + dt * a.J_v_ba + A * b.J_p_ba;
  out.J_effects = F * a.J_effects + G * b.J_effects;
  return out;
}

}  // namespace dn
