#pragma once

#include <dn/eigen_alignment.h>

#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/SVD>

namespace dn {

/// The rotation that fits pairs of vectors best.
struct RotationFit {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d singular_values = Eigen::Vector3d::Zero();  ///< of B, from the largest
  /// 1, 1, and the sign of the smallest singular value in the trace of R^T B.
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
};

/// Returns the rotation R that minimises sum_k |b_k - R a_k|^2 for B = sum_k b_k a_k^T: the
/// solution of Wahba's problem by singular values. The trace of R^T B is singular_values . signs.
inline RotationFit FitRotation(const Eigen::Matrix3d& B) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(B, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d signs(1.0, 1.0, (svd.matrixU() * svd.matrixV().transpose()).determinant());
  return {svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose(), svd.singularValues(),
          signs};
}

}  // namespace dn
