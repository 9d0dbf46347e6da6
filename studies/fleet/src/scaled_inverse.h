#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace dn::fleet_internal {

/// Inverse of a positive definite matrix whose unknowns have different units. It is scaled to a
/// unit diagonal first.
class ScaledInverse {
 public:
  explicit ScaledInverse(const Eigen::MatrixXd& A)
      : scale_(A.diagonal().cwiseSqrt().cwiseInverse()),
        llt_(scale_.asDiagonal() * A * scale_.asDiagonal()) {}

  /// Returns A^-1 B.
  Eigen::MatrixXd Solve(const Eigen::MatrixXd& B) const {
    return scale_.asDiagonal() * llt_.solve(scale_.asDiagonal() * B);
  }

  /// Returns A^-1.
  Eigen::MatrixXd Matrix() const {
    return Solve(Eigen::MatrixXd::Identity(scale_.size(), scale_.size()));
  }

 private:
  Eigen::VectorXd scale_;
  Eigen::LLT<Eigen::MatrixXd> llt_;
};

}  // namespace dn::fleet_internal
