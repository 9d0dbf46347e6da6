#pragma once

#include <Eigen/Core>

namespace dn::diagnosis_internal {

/// Returns a lower triangular L with L L^T = C, for a C that is positive semidefinite up to
/// rounding. Sets a column to zero if the columns before it leave at most its `rounding` of its
/// diagonal entry. `rounding` has one value per diagonal entry, in the units of C.
Eigen::MatrixXd SemidefiniteRoot(const Eigen::MatrixXd& C, const Eigen::VectorXd& rounding);

}  // namespace dn::diagnosis_internal
