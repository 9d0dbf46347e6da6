#include <dn/symmetric_eigen.h>
#include <gtest/gtest.h>

namespace dn::core_test {

// A = [2 1; 1 2] has the eigenvalues 1 and 3 with the eigenvectors (1, -1) and (1, 1).
TEST(SymmetricEigen, OfATwoByTwo) {
  const SymmetricEigen eigen((Eigen::Matrix2d() << 2.0, 1.0, 1.0, 2.0).finished());
  EXPECT_NEAR(eigen.values[0], 1.0, 1e-15);
  EXPECT_NEAR(eigen.values[1], 3.0, 1e-15);
  EXPECT_NEAR(eigen.vectors(0, 0), -eigen.vectors(1, 0), 1e-15);
  EXPECT_NEAR(eigen.vectors(0, 1), eigen.vectors(1, 1), 1e-15);
}

TEST(SymmetricEigen, ReadsTheLowerTriangle) {
  const SymmetricEigen eigen((Eigen::Matrix2d() << 2.0, 99.0, 1.0, 2.0).finished());
  EXPECT_NEAR(eigen.values[1], 3.0, 1e-15);
}

}  // namespace dn::core_test
