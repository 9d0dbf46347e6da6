#include "semidefinite_root.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <random>

namespace dn::diagnosis_internal {

Eigen::MatrixXd Drawn(Eigen::Index rows, Eigen::Index columns, unsigned seed) {
  std::mt19937 rng(seed);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd X(rows, columns);
  for (double& x : X.reshaped()) x = normal(rng);
  return X;
}

TEST(SemidefiniteRoot, OfARegularMatrixIsItsCholeskyFactor) {
  const Eigen::MatrixXd X = Drawn(6, 40, 1);
  const Eigen::MatrixXd C = X * X.transpose();
  const Eigen::MatrixXd L = SemidefiniteRoot(C, 1e-7 * C.diagonal());
  EXPECT_LT((L * L.transpose() - C).norm(), 1e-12 * C.norm());
  EXPECT_TRUE(L.isLowerTriangular());
  EXPECT_GT(L.diagonal().minCoeff(), 0.0);
}

// The matrix has thirty columns of rank ten, in units that differ by many decades. Rounding has
// made its smallest eigenvalues negative.
TEST(SemidefiniteRoot, OfASingularMatrixIsRightBesideRounding) {
  const Eigen::Index n = 30;
  const Eigen::MatrixXd X = Drawn(n, 10, 2);
  const Eigen::MatrixXd E = Drawn(n, n, 3);
  Eigen::MatrixXd C = X * X.transpose() + 1e-11 * (E + E.transpose());
  Eigen::VectorXd unit(n);
  for (Eigen::Index k = 0; k < n; ++k) unit[k] = std::pow(10.0, static_cast<double>(k % 7) - 3.0);
  C = unit.asDiagonal() * C * unit.asDiagonal();
  const Eigen::MatrixXd L = SemidefiniteRoot(C, 1e-7 * C.diagonal());
  const Eigen::VectorXd inverse = C.diagonal().cwiseSqrt().cwiseInverse();
  EXPECT_LT(
      (inverse.asDiagonal() * (L * L.transpose() - C) * inverse.asDiagonal()).cwiseAbs().maxCoeff(),
      1e-6);
  EXPECT_EQ((L.diagonal().array() > 0.0).count(), 10);
}

// A component that is absorbed up to rounding has no noise of its own, whatever its diagonal entry
// is.
TEST(SemidefiniteRoot, WhatRoundingLeavesIsZero) {
  Eigen::Matrix2d C;
  C << 1.0, 1e-9, 1e-9, -1e-12;
  const Eigen::MatrixXd L = SemidefiniteRoot(C, Eigen::Vector2d(1e-7, 1e-7));
  EXPECT_EQ(L(0, 0), 1.0);
  EXPECT_EQ(L(1, 1), 0.0);
  EXPECT_NEAR(L(1, 0), 1e-9, 1e-20);
}

}  // namespace dn::diagnosis_internal
