#pragma once

#include <dn/factor.h>

#include <Eigen/Core>
#include <vector>

namespace dn {

/// A joint prior of several blocks, linear in their tangents at the centers c:
///
///   r = R [x_0 (-) c_0; x_1 (-) c_1; ...] + d              [rows of R], unitless
///
/// Jacobians: R times the derivative of Minus, exact for vectors and rotations, numerical to 1e-9
/// for other kinds. dn::Eliminate makes these priors.
class LinearPrior final : public DynamicFactor {
 public:
  /// `center` has the stored numbers of all blocks one after the other; R has one column per
  /// tangent coordinate of all blocks. Throws InvalidInput if a size does not fit, or for a number
  /// that is not finite. `nonlinearity` is that of the factors that the prior replaces. It is the
  /// change of its residual that R does not explain, for a movement of one sigma. It grows with the
  /// square of the movement.
  LinearPrior(std::vector<BlockKind> kinds, Eigen::VectorXd center, Eigen::MatrixXd R,
              Eigen::VectorXd d, double nonlinearity = 0.0);

  bool Evaluate(double const* const* x, double* r, double** J) const override;

  /// Returns [x_0 (-) c_0; ...], the movement of the blocks from the centers.
  Eigen::VectorXd Movement(double const* const* x) const;

  const Eigen::VectorXd& center() const { return center_; }
  const Eigen::MatrixXd& sqrt_information() const { return R_; }
  const Eigen::VectorXd& offset() const { return d_; }
  double nonlinearity() const { return nonlinearity_; }

 private:
  Eigen::VectorXd center_;
  Eigen::MatrixXd R_;
  Eigen::VectorXd d_;
  double nonlinearity_;
};

}  // namespace dn
