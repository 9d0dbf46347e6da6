#pragma once

#include <dn/network.h>

#include <string>
#include <vector>

namespace dn {

/// Options of CheckJacobians.
struct JacobianCheckOptions {
  /// Largest accepted difference, relative to the largest entry of the Jacobian of the block.
  double tolerance = 1e-5;
  /// Checks at most this many factors of each class, evenly spread over them; 0 checks all.
  int most_per_class = 0;
  int threads = 1;

  /// Throws InvalidConfig naming the option, its value and its bound.
  void Validate() const;
};

/// The entry of a Jacobian that differs most from the numerical derivative.
struct JacobianFault {
  FactorId factor = -1;
  BlockId block = -1;
  int row = 0;             ///< residual of the factor
  int column = 0;          ///< tangent coordinate of the block
  double computed = 0.0;   ///< entry of the factor, lifted to the tangent by PlusJacobian
  double numerical = 0.0;  ///< derivative of the residual along Plus
  std::string text;        ///< names the factor, the block and the entry
};

/// Compares the Jacobians of the active factors at the present values with numerical derivatives of
/// their residuals in the tangent (Ridders). Returns the worst entry of each factor and block that
/// differ: empty if all are right. A wrong PlusJacobian of a block kind shows in its factors.
///
/// Blocks that are constant and factors that are undefined at the present values are left out. An
/// entry also counts as right if its numerical derivative is too uncertain to decide. The same
/// holds for one of the derivatives at a kink. Costs about 70 evaluations per tangent coordinate of
/// each factor. Throws InvalidInput naming the factor if a factor throws at the present values.
std::vector<JacobianFault> CheckJacobians(const Network& network,
                                          const JacobianCheckOptions& options = {});

}  // namespace dn
