#pragma once

#include <Eigen/Core>

namespace dn::internal {

/// Lower triangle L with L L^T = C, of a C that is positive semidefinite but for rounding: a column
/// of which the columns before it leave no more than its `rounding` (one per diagonal entry, in the
/// units of C) is zero.
Eigen::MatrixXd SemidefiniteRoot(const Eigen::MatrixXd& C, const Eigen::VectorXd& rounding);

}  // namespace dn::internal
