#pragma once

#include <dn/factor.h>
#include <dn/geo/local_frame.h>
#include <dn/imu/preintegration.h>
#include <dn/imu/strapdown.h>
#include <dn/noise.h>
#include <dn/rotation.h>

#include <Eigen/Core>
#include <vector>

namespace dn {

/// Gravitation (m/s^2, map axes) in addition to the normal one, per unit of the values of one
/// effect.
using GravitationBasis = Eigen::Matrix3Xd;

/// Inertial increments between two nodes on the rotating Earth, in the exact inertial form.
///
///   r_R = Log( Exp(J_q_bg d_bg + J_q_e d_e)^T dR^T R_i^T C R_j )
///   r_v = R_i^T [ C V_j - V_i - dt/2 (G_i + C G_j) ]  - dv - J_v_bg d_bg - J_v_ba d_ba - J_v_e d_e
///   r_p = R_i^T [ C rho_j - rho_i - V_i dt - dt^2 (G_i/3 + C G_j/6) ]     - dp - ...  (likewise)
///   r   = W (r_R, r_v, r_p)                                                    [9], unitless
///
/// with rho = r0 + p, V = v + w x rho, C = Exp(w dt) (see EarthStep) and W^T W the inverse of the
/// increments' covariance. d_bg = (sum of the gyro bias blocks) - linearisation; d_ba is defined
/// likewise. d_e = e - the values of the effects at which the increments were integrated. Every
/// effect on gravitation adds D g to G, with D its GravitationBasis.
///
///   block       | symbol | stored | tangent | meaning
///   ------------|--------|--------|---------|-----------------------------------------------
///     0, 3      | q_mb   |   4    |    3    | rotation body -> map at i, j, (x, y, z, w)
///     1, 4      | p_mb   |   3    |    3    | body origin in map at i, j, m
///     2, 5      | v_m    |   3    |    3    | velocity with respect to the Earth in map, m/s
///     6 ..      | b_g    |   3    |    3    | one per gyro bias process, body, rad/s
///     then      | b_a    |   3    |    3    | one per accelerometer bias process, body, m/s^2
///     then      | e      |   n    |    n    | one per effect of the increments' linearisation, SI
///     last      | g      |   n    |    n    | one per effect on gravitation, SI
///
/// Gravitation is linearised about the nominal positions: G(p) = G(p_nominal) + Gamma (p -
/// p_nominal). The error is below 1e-9 m/s^2 within 30 m and 1e-6 m/s^2 within 1 km of them.
///
/// Jacobians are analytic, with no term dropped; the tangent of the rotations is right, full angle,
/// rad. The Jacobian of r_R with respect to the attitude at i contains R_j^T C^T R_i, the rotation
/// of the body over the interval. Approximating it by the identity would make the accelerometer
/// bias and the boresight inseparable. Degenerate when: never on its own; the heading is observable
/// only under horizontal acceleration. A raw (sample by sample) network uses this factor with the
/// increments of one sample. Source: Forster et al. 2017, eq. (45), in the inertial frame of
/// Brossard et al. 2021.
class PreintegratedInertial final : public DynamicFactor {
 public:
  /// Creates the factor. The blocks of the effects are those of increments.linearisation.effects
  /// and of `attraction`. Throws InvalidInput if the covariance of the increments is not positive
  /// definite or their interval is not positive. Also throws if a nominal position is not finite or
  /// a number of biases is negative.
  PreintegratedInertial(const Preintegrated& increments, const LocalFrame& frame,
                        const Eigen::Vector3d& p_i_nominal_m, const Eigen::Vector3d& p_j_nominal_m,
                        int num_gyro_biases, int num_accel_biases,
                        const std::vector<GravitationBasis>& attraction = {});

  const Preintegrated& increments() const { return increments_; }

  /// Computes r (9) from the blocks x in the order above.
  template <class T>
  bool Residual(T const* const* x, T* r_data) const {
    using Vec3 = Eigen::Matrix<T, 3, 1>;
    using Quat = Eigen::Quaternion<T>;
    const Eigen::Map<const Quat> q_i(x[0]), q_j(x[3]);
    const Eigen::Map<const Vec3> p_i(x[1]), v_i(x[2]), p_j(x[4]), v_j(x[5]);
    const Vec3 d_bg = SumBlocks(x + 6, num_gyro_biases_) -
                      increments_.linearisation.gyro_bias_radps.template cast<T>();
    const Vec3 d_ba = SumBlocks(x + 6 + num_gyro_biases_, num_accel_biases_) -
                      increments_.linearisation.accel_bias_mps2.template cast<T>();
    const Eigen::Matrix<T, 9, 1> by_effects = EffectIncrements(x);

    const Vec3 xi = Times(increments_.J_q_bg, d_bg) + by_effects.template head<3>();
    const Quat dq = increments_.delta_q.template cast<T>() * Exp(xi);
    const Quat q_ij = q_i.conjugate() * (q_C_.template cast<T>() * q_j);
    const Vec3 r_R = Log(Quat(dq.conjugate() * q_ij));

    Vec3 v_attraction = Vec3::Zero(), p_attraction = Vec3::Zero();
    AddGravitation(x, &v_attraction, &p_attraction);
    const Vec3 y_v =
        q_i.conjugate() * Vec3(Times(C_, v_j) - v_i + Times(v_p_i_, p_i) + Times(v_p_j_, p_j) +
                               v_0_.template cast<T>() + v_attraction);
    const Vec3 y_p =
        q_i.conjugate() * Vec3(T(-increments_.dt_s()) * v_i + Times(p_p_i_, p_i) +
                               Times(p_p_j_, p_j) + p_0_.template cast<T>() + p_attraction);
    const Vec3 r_v = y_v - increments_.delta_v.template cast<T>() -
                     Times(increments_.J_v_bg, d_bg) - Times(increments_.J_v_ba, d_ba) -
                     by_effects.template segment<3>(3);
    const Vec3 r_p = y_p - increments_.delta_p.template cast<T>() -
                     Times(increments_.J_p_bg, d_bg) - Times(increments_.J_p_ba, d_ba) -
                     by_effects.template tail<3>();

    Eigen::Matrix<T, 9, 1> stacked;
    stacked << r_R, r_v, r_p;
    Eigen::Map<Eigen::Matrix<T, 9, 1>> r(r_data);
    r.noalias() = W_.template cast<T>() * stacked;
    return true;
  }

  bool Evaluate(double const* const* x, double* r, double** J) const override;

 private:
  template <class T>
  static Eigen::Matrix<T, 3, 1> SumBlocks(T const* const* x, int count) {
    Eigen::Matrix<T, 3, 1> sum = Eigen::Matrix<T, 3, 1>::Zero();
    for (int i = 0; i < count; ++i) sum += Eigen::Map<const Eigen::Matrix<T, 3, 1>>(x[i]);
    return sum;
  }
  /// Returns the change of the increments by their effects, in tangent order.
  template <class T>
  Eigen::Matrix<T, 9, 1> EffectIncrements(T const* const* x) const {
    Eigen::Matrix<T, 9, 1> sum = Eigen::Matrix<T, 9, 1>::Zero();
    Eigen::Index column = 0;
    int block = first_effect();
    for (const ImuEffectValue& one : increments_.linearisation.effects) {
      for (Eigen::Index c = 0; c < one.value.size(); ++c, ++column) {
        const T d = x[block][c] - one.value[c];
        sum += increments_.J_effects.col(column).template cast<T>() * d;
      }
      ++block;
    }
    return sum;
  }

  /// Adds the contribution of the effects on gravitation to the brackets of r_v and r_p.
  template <class T>
  void AddGravitation(T const* const* x, Eigen::Matrix<T, 3, 1>* v,
                      Eigen::Matrix<T, 3, 1>* p) const {
    int block = first_attraction();
    for (const GravitationBracket& one : attraction_) {
      for (Eigen::Index c = 0; c < one.v.cols(); ++c) {
        *v += one.v.col(c).template cast<T>() * x[block][c];
        *p += one.p.col(c).template cast<T>() * x[block][c];
      }
      ++block;
    }
  }

  template <class Vector>
  static auto Times(const Eigen::Matrix3d& M, const Vector& v) {
    return Eigen::Matrix<typename Vector::Scalar, 3, 1>(M.template cast<typename Vector::Scalar>() *
                                                        v);
  }

  /// Derivatives of the brackets of r_v and r_p with respect to the values of an effect on
  /// gravitation.
  struct GravitationBracket {
    Eigen::Matrix3Xd v, p;
  };

  int first_effect() const { return 6 + num_gyro_biases_ + num_accel_biases_; }
  int first_attraction() const {
    return first_effect() + static_cast<int>(increments_.linearisation.effects.size());
  }
  void EvaluateJacobians(double const* const* x, double** J) const;
  void EvaluateEffectJacobians(double const* const* x, const Eigen::Matrix3d& J_R_xi,
                               const Eigen::Matrix3d& R_i_inverse, double** J) const;

  Preintegrated increments_;
  int num_gyro_biases_;
  int num_accel_biases_;
  Eigen::Matrix<double, 9, 9> W_;
  Eigen::Matrix3d C_;
  Eigen::Quaterniond q_C_;
  // Constant terms of the brackets of r_v and r_p: C v_j - v_i + v_p_i p_i + v_p_j p_j + v_0 and
  // -v_i dt + p_p_i p_i + p_p_j p_j + p_0.
  Eigen::Matrix3d v_p_i_, v_p_j_, p_p_i_, p_p_j_;
  Eigen::Vector3d v_0_, p_0_;
  std::vector<GravitationBracket> attraction_;
};

}  // namespace dn
