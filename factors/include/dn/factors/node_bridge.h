#pragma once

#include <dn/geo/local_frame.h>
#include <dn/imu/preintegration.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace dn {

/// What the attitude of the node after an epoch tells of the increments from the node before it.
///
/// The white noise z_t of the increments to the epoch is part of that of the whole interval, of
/// which the two nodes know the rotation z_D:
///
///   E(z_t | z_D) = K r,   K = Cov(z_t, z_D) Cov(z_D)^-1,
///   r = Log( Exp(J_q_e d_e)^T dR^T R_i^T C R_j ),        d_e as in PreintegratedInertial
///   Cov(z_t | z_D) = Cov(z_t) - K Cov(z_D) K^T
///
/// With the increments moved by K r their remaining noise is independent of the rotation of the
/// inertial edge: it is not counted twice, and falls from that of a walk to that of a bridge, a
/// quarter in the middle of the interval. The biases stay at the linearisation: a change of the
/// gyro bias moves z_t and K r alike. For the same reason the velocities are left out: through them
/// an accelerometer bias would turn the points.
/// Source: conditional normal distribution.
class NodeBridge {
 public:
  using Vector9 = Eigen::Matrix<double, 9, 1>;
  using Matrix9 = Eigen::Matrix<double, 9, 9>;

  /// partial: increments from a node to an epoch; whole: from that node to the next, with the same
  /// linearisation. Beyond the next node there is nothing to bridge: K is zero.
  /// Throws InvalidInput when the two begin at different times or their effects differ.
  NodeBridge(const LocalFrame& frame, const Preintegrated& partial, const Preintegrated& whole);

  /// Of the partial increments given the rotation between the nodes.
  const Matrix9& covariance() const { return covariance_; }

  /// Of the rotation increment of the whole interval by the values of the effects.
  const Eigen::Matrix3Xd& J_q_effects() const { return J_q_effects_; }

  /// K r and its derivatives with respect to the attitudes (right tangent) and to what the effects
  /// add to the rotation increment of the whole interval; increments in the tangent order of
  /// Preintegrated.
  struct Correction {
    Vector9 increments;
    Eigen::Matrix<double, 9, 3> J_q, J_q_after, J_whole;
  };
  /// q, q_after: body -> map at the two nodes; d_effects: values of the effects less those of the
  /// linearisation.
  Correction At(const Eigen::Quaterniond& q, const Eigen::Quaterniond& q_after,
                const Eigen::VectorXd& d_effects) const;

 private:
  Eigen::Quaterniond q_C_, delta_q_;
  Eigen::Matrix3Xd J_q_effects_;
  Eigen::Matrix<double, 9, 3> gain_ = Eigen::Matrix<double, 9, 3>::Zero();
  Matrix9 covariance_;
};

}  // namespace dn
