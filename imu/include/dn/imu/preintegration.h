#pragma once

#include <dn/imu/imu_data.h>
#include <dn/imu/imu_effect.h>
#include <dn/imu/imu_model.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <vector>

namespace dn {

/// Constants that correct the raw samples: the biases are subtracted first, then each effect in its
/// turn is taken out, the one that comes last in the sensor first.
struct ImuCorrection {
  Eigen::Vector3d gyro_bias_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_bias_mps2 = Eigen::Vector3d::Zero();
  ImuEffectValues effects = {};
};

/// Inertial increments over [t_begin_s, t_end_s], integrated in the inertial frame that coincides
/// with the body at t_begin_s; free of Earth terms, hence integrated once whatever the trajectory.
///
///   delta_q            body at the end -> body at the begin
///   delta_v, delta_p   single and double integral of the specific force, in body axes at the begin
struct InertialIncrements {
  double t_begin_s = 0.0;
  double t_end_s = 0.0;
  Eigen::Quaterniond delta_q = Eigen::Quaterniond::Identity();
  Eigen::Vector3d delta_v = Eigen::Vector3d::Zero();
  Eigen::Vector3d delta_p = Eigen::Vector3d::Zero();
  /// Corrected angular rate and specific force at t_end_s (of the last sample's linear model).
  Eigen::Vector3d w_end_b_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d f_end_b_mps2 = Eigen::Vector3d::Zero();

  double dt_s() const { return t_end_s - t_begin_s; }
};

/// Increments with their covariance and their derivatives.
///
/// Tangent order of covariance and Jacobians: rotation (right, at the end), velocity, position.
/// J_x_bg, J_x_ba: derivatives with respect to the gyro and accelerometer bias at `linearisation`:
///
///   delta_q(bg) = delta_q Exp(J_q_bg d_bg),  delta_v(bg, ba) = delta_v + J_v_bg d_bg + J_v_ba d_ba
///
/// and delta_p alike; d d_e of the effects' values enters as the biases do, by the columns of
/// J_effects (rows in the tangent order above). A gyro that takes its rate from specific force
/// makes delta_q depend on the accelerometer bias; that one derivative is left out. Source: Forster
/// et al. 2017 (on-manifold preintegration) with the coning and sculling terms of a rate and a
/// specific force that are linear in time within each sample.
struct Preintegrated : InertialIncrements {
  Eigen::Matrix<double, 9, 9> covariance = Eigen::Matrix<double, 9, 9>::Zero();
  Eigen::Matrix3d J_q_bg = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d J_v_bg = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d J_v_ba = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d J_p_bg = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d J_p_ba = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 9, Eigen::Dynamic> J_effects;  ///< of all values of linearisation.effects
  ImuCorrection linearisation;
};

/// White noise that the covariance of increments grows from.
struct PreintegrationNoise {
  double gyro_white_rad_per_sqrt_s = 0.0;
  double accel_white_mps_per_sqrt_s = 0.0;
  /// Floor added to the position covariance of every increment: quantisation and conditioning.
  double position_floor_m = 1e-6;
  /// A sample within one has its variance beside that of the densities.
  std::vector<ImuVibration> vibration = {};
};

/// Integrates the samples over [t_begin_s, t_end_s]. The ends need not be sample epochs: within a
/// sample the rates are taken linear in time, with the sample's mean and a slope from its two
/// neighbours on either side in the file (one, or one-sided, beside a gap and at the ends of the
/// data), so that the parts of a split interval compose to the whole wherever it is split.
///
/// The derivatives with respect to the effects of the correction come with the increments, at about
/// 0.03 us per sample and effect. The white noise is a density: the covariance is
/// that of continuous white noise and does not depend on the sampling. The errors of bridged holes
/// (ImuBridge) and vibration enter as white noise within their samples, vibration with the density
/// sigma^2 dt; a sample of which the interval has only a part adds that part.
/// Throws InvalidInput when the interval is not positive, or not covered by samples without a gap
/// (naming the times). An end may exceed the data by 1e-7 s (rounding of time tags).
/// Linear in the number of samples, about 0.2 us each; finding the first is logarithmic.
Preintegrated Preintegrate(const ImuData& imu, double t_begin_s, double t_end_s,
                           const ImuCorrection& correction, const PreintegrationNoise& noise);

/// The increments of Preintegrate from one begin to ends that come in the order of time: every
/// sample between is integrated once. `imu` and `noise` must outlive it. Throws as Preintegrate.
class GrowingIncrements {
 public:
  GrowingIncrements(const ImuData& imu, double t_begin_s, const ImuCorrection& correction,
                    const PreintegrationNoise& noise);
  ~GrowingIncrements();
  GrowingIncrements(const GrowingIncrements&) = delete;
  GrowingIncrements& operator=(const GrowingIncrements&) = delete;

  /// Bit by bit what Preintegrate gives. Throws InvalidInput where t_end_s precedes that of the call
  /// before, too.
  Preintegrated To(double t_end_s);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// The increments of Preintegrate alone, at a fifth of its time: to ends that come in the order of
/// time, and to one end. `imu` must outlive it. Throws as GrowingIncrements.
class GrowingMotion {
 public:
  GrowingMotion(const ImuData& imu, double t_begin_s, const ImuCorrection& correction);
  ~GrowingMotion();
  GrowingMotion(const GrowingMotion&) = delete;
  GrowingMotion& operator=(const GrowingMotion&) = delete;

  InertialIncrements To(double t_end_s);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

InertialIncrements IntegrateMotion(const ImuData& imu, double t_begin_s, double t_end_s,
                                   const ImuCorrection& correction);

/// Increments of zero length at t_s: identity, zero covariance and Jacobians, and the corrected
/// rate and specific force of the sample that ends at or contains t_s.
/// Throws InvalidInput when no sample covers t_s.
Preintegrated IdentityIncrement(const ImuData& imu, double t_s, const ImuCorrection& correction);

/// The increments of two adjoining intervals as one: a over [t0, t1], b over [t1, t2]. Both must
/// have the same linearisation (not checked); position_floor enters twice.
Preintegrated Compose(const Preintegrated& a, const Preintegrated& b);

}  // namespace dn
