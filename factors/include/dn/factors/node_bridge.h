#pragma once

#include <dn/eigen_alignment.h>
#include <dn/geo/local_frame.h>
#include <dn/imu/preintegration.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace dn {

/// Conditions the increments from a node to an epoch on the rotation between that node and the
/// next.
///
/// The white noise z_t of the increments to the epoch is part of the noise of the whole interval.
/// The two nodes observe its rotation part z_D:
///
///   E(z_t | z_D) = K r,   K = Cov(z_t, z_D) Cov(z_D)^-1,
///   r = Log( Exp(J_q_e d_e)^T dR^T R_i^T C R_j ),        d_e as in PreintegratedInertial
///   Cov(z_t | z_D) = Cov(z_t) - K Cov(z_D) K^T
///
/// After the increments are moved by K r, their remaining noise is independent of the rotation of
/// the inertial edge. It is therefore not counted twice. Its variance falls from that of a random
/// walk to that of a Brownian bridge, a quarter in the middle of the interval. The biases stay at
/// the linearisation, because a change of the gyro bias moves z_t and K r equally. For the same
/// reason the velocities are not used: through them an accelerometer bias would rotate the points.
/// Source: conditional normal distribution.
class IncrementConditioning {
 public:
  using Vector9 = Eigen::Matrix<double, 9, 1>;
  using Matrix9 = Eigen::Matrix<double, 9, 9>;

  /// Creates the conditioning. `partial` are the increments from a node to an epoch, `whole` those
  /// from that node to the next, with the same linearisation. For an epoch after the next node K is
  /// zero. Throws InvalidInput if the two start at different times or their effects differ.
  IncrementConditioning(const LocalFrame& frame, const Preintegrated& partial,
                        const Preintegrated& whole);

  /// Returns the covariance of the partial increments given the rotation between the nodes.
  const Matrix9& covariance() const { return covariance_; }

  /// Returns the Jacobian of the rotation increment of the whole interval with respect to the
  /// values of the effects.
  const Eigen::Matrix3Xd& J_q_effects() const { return J_q_effects_; }

  /// K r and its derivatives with respect to the two attitudes (right tangent) and to the change of
  /// the whole rotation increment by effects. The increments are in the tangent order of
  /// Preintegrated.
  struct Correction {
    Vector9 increments;
    Eigen::Matrix<double, 9, 3> J_q, J_q_after, J_whole;
  };
  /// Returns the correction. q and q_after rotate body -> map at the two nodes; d_effects are the
  /// values of the effects minus those of the linearisation.
  Correction At(const Eigen::Quaterniond& q, const Eigen::Quaterniond& q_after,
                const Eigen::VectorXd& d_effects) const;

 private:
  Eigen::Quaterniond q_C_, delta_q_;
  Eigen::Matrix3Xd J_q_effects_;
  Eigen::Matrix<double, 9, 3> gain_ = Eigen::Matrix<double, 9, 3>::Zero();
  Matrix9 covariance_;
};

}  // namespace dn
