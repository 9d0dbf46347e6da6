#pragma once

#include <dn/eigen_alignment.h>
#include <dn/imu/imu_data.h>
#include <dn/imu/imu_effect.h>
#include <dn/imu/imu_model.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <vector>

namespace dn {

/// Constants that correct the raw samples. The biases are subtracted first; then the effects are
/// removed one after the other, in the reverse order of the sensor.
struct ImuCorrection {
  Eigen::Vector3d gyro_bias_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_bias_mps2 = Eigen::Vector3d::Zero();
  ImuEffectValues effects = {};
};

/// Inertial increments over [t_begin_s, t_end_s], in the inertial frame that coincides with the
/// body at t_begin_s. They contain no Earth terms, so that they are integrated only once for any
/// trajectory.
///
///   delta_q            rotation from body at the end to body at the beginning
///   delta_v, delta_p   single and double integral of the specific force, in body axes at the
///                      beginning
struct InertialIncrements {
  double t_begin_s = 0.0;
  double t_end_s = 0.0;
  Eigen::Quaterniond delta_q = Eigen::Quaterniond::Identity();
  Eigen::Vector3d delta_v = Eigen::Vector3d::Zero();
  Eigen::Vector3d delta_p = Eigen::Vector3d::Zero();
  /// Corrected angular rate and specific force at t_end_s, from the linear model of the last
  /// sample.
  Eigen::Vector3d w_end_b_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d f_end_b_mps2 = Eigen::Vector3d::Zero();

  double dt_s() const { return t_end_s - t_begin_s; }
};

/// Increments with their covariance and derivatives.
///
/// Tangent order of covariance and Jacobians: rotation (right, at the end), velocity, position.
/// J_x_bg, J_x_ba: derivatives with respect to the gyro and accelerometer bias at `linearisation`:
///
///   delta_q(bg) = delta_q Exp(J_q_bg d_bg),  delta_v(bg, ba) = delta_v + J_v_bg d_bg + J_v_ba d_ba
///
/// and in the same way for delta_p. Changes d_e of the values of the effects enter in the same way,
/// by the columns of J_effects (rows in the tangent order above). Neglected: a gyro effect that
/// depends on specific force makes delta_q depend on the accelerometer bias. Source: Forster et al.
/// 2017 (on-manifold preintegration), with coning and sculling terms of a rate and a specific force
/// that are linear in time within each sample.
struct Preintegrated : InertialIncrements {
  Eigen::Matrix<double, 9, 9> covariance = Eigen::Matrix<double, 9, 9>::Zero();
  Eigen::Matrix3d J_q_bg = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d J_v_bg = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d J_v_ba = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d J_p_bg = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d J_p_ba = Eigen::Matrix3d::Zero();
  /// Derivatives with respect to all values of linearisation.effects.
  Eigen::Matrix<double, 9, Eigen::Dynamic> J_effects;
  ImuCorrection linearisation;
};

/// White noise that determines the covariance of increments.
struct PreintegrationNoise {
  double gyro_white_rad_per_sqrt_s = 0.0;
  double accel_white_mps_per_sqrt_s = 0.0;
  /// Floor added to the position covariance of every increment, for quantisation and conditioning.
  double position_floor_m = 1e-6;
  /// Vibrations; the variance of a sample within one adds to that of the densities.
  std::vector<ImuVibration> vibration = {};
};

/// Integrates the samples over [t_begin_s, t_end_s]. The ends need not be sample epochs. Within a
/// sample the rates are linear in time. They have the mean of the sample, and a slope from its two
/// neighbours on either side in the file. Next to a gap and at the ends of the data the slope uses
/// one neighbour, or one side only. Therefore the parts of an interval compose to the whole
/// wherever it is split.
///
/// The derivatives with respect to the effects of the correction take about 0.03 us per sample and
/// effect. The white noise is a density: the covariance is that of continuous white noise and does
/// not depend on the sampling. The errors of bridged holes (ImuBridge) and the vibration enter as
/// white noise within their samples, the vibration with density sigma^2 dt. If the interval
/// contains only part of a sample, it adds only that part.
/// Throws InvalidInput, with the times, if the interval is not positive or not covered by samples
/// without a gap. An end may exceed the data by 1e-7 s (rounding of time tags). Complexity: linear
/// in the number of samples, about 0.2 us each; finding the first sample is logarithmic.
Preintegrated Preintegrate(const ImuData& imu, double t_begin_s, double t_end_s,
                           const ImuCorrection& correction, const PreintegrationNoise& noise);

/// Computes the increments of Preintegrate from one beginning to several ends in increasing order.
/// Every sample is integrated only once. `imu` and `noise` must outlive this object. Throws as
/// Preintegrate does.
class IncrementalPreintegrator {
 public:
  IncrementalPreintegrator(const ImuData& imu, double t_begin_s, const ImuCorrection& correction,
                           const PreintegrationNoise& noise);
  ~IncrementalPreintegrator();
  IncrementalPreintegrator(const IncrementalPreintegrator&) = delete;
  IncrementalPreintegrator& operator=(const IncrementalPreintegrator&) = delete;

  /// Returns exactly the same result as Preintegrate. Throws InvalidInput also if t_end_s precedes
  /// that of the call before.
  Preintegrated To(double t_end_s);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// Computes only the increments of Preintegrate, without covariance and derivatives, in a fifth of
/// the time. The ends must come in increasing order. `imu` must outlive this object. Throws as
/// IncrementalPreintegrator.
class IncrementalMotionIntegrator {
 public:
  IncrementalMotionIntegrator(const ImuData& imu, double t_begin_s,
                              const ImuCorrection& correction);
  ~IncrementalMotionIntegrator();
  IncrementalMotionIntegrator(const IncrementalMotionIntegrator&) = delete;
  IncrementalMotionIntegrator& operator=(const IncrementalMotionIntegrator&) = delete;

  /// Returns the increments up to t_end_s. Throws InvalidInput also if t_end_s precedes that of the
  /// call before.
  InertialIncrements To(double t_end_s);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// Computes the increments of IncrementalMotionIntegrator for a single end.
InertialIncrements IntegrateMotion(const ImuData& imu, double t_begin_s, double t_end_s,
                                   const ImuCorrection& correction);

/// Returns increments of zero length at t_s: identity, zero covariance and Jacobians. They contain
/// the corrected rate and specific force of the sample that ends at or contains t_s. Throws
/// InvalidInput if no sample covers t_s.
Preintegrated IdentityIncrement(const ImuData& imu, double t_s, const ImuCorrection& correction);

/// Composes the increments of two adjacent intervals, a over [t0, t1] and b over [t1, t2]. Both
/// must have the same linearisation (not checked). The position floor is added twice.
Preintegrated Compose(const Preintegrated& a, const Preintegrated& b);

}  // namespace dn
