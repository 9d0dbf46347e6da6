#include <dn/error.h>
#include <dn/linear_prior.h>
#include <dn/manifold.h>
#include <dn/pose.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "testing/factor_consistency.h"
#include "testing/random.h"

namespace dn::core_test {

Eigen::VectorXd Stacked(const std::vector<Eigen::VectorXd>& parts) {
  Eigen::Index size = 0;
  for (const Eigen::VectorXd& part : parts) size += part.size();
  Eigen::VectorXd all(size);
  size = 0;
  for (const Eigen::VectorXd& part : parts) {
    all.segment(size, part.size()) = part;
    size += part.size();
  }
  return all;
}

Eigen::VectorXd PoseNumbers(std::mt19937& rng) {
  Eigen::VectorXd x(7);
  x << testing::RandomRotation(rng).coeffs(), testing::RandomVector(rng, 5.0);
  return x;
}

TEST(LinearPrior, IsRTimesTheMovementPlusD) {
  const std::vector<BlockKind> kinds{Scalar::kKind, VectorKind(2)};
  const LinearPrior prior(kinds, Eigen::Vector3d(1.0, 2.0, 3.0),
                          (Eigen::MatrixXd(2, 3) << 1, 2, 3, 0, 1, -1).finished(),
                          Eigen::Vector2d(0.5, -0.5));
  const double a = 2.0;
  const Eigen::Vector2d b(2.0, 5.0);
  const double* x[] = {&a, b.data()};
  Eigen::Vector2d r;
  ASSERT_TRUE(prior.Evaluate(x, r.data(), nullptr));
  EXPECT_EQ(r, Eigen::Vector2d(1.0 + 6.0 + 0.5, -2.0 - 0.5));
  EXPECT_EQ(prior.Movement(x), Eigen::Vector3d(1.0, 0.0, 2.0));
}

TEST(LinearPrior, HasRightJacobiansForEveryKind) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 rng(seed);
    const auto rotation = [&] { return Eigen::VectorXd(testing::RandomRotation(rng).coeffs()); };
    const std::vector<BlockKind> kinds{Rotation::kKind, VectorKind(3), LeftRotation::kKind,
                                       MakeBlockKind<Pose>()};
    const LinearPrior prior(
        kinds, Stacked({rotation(), testing::RandomVector(rng, 5.0), rotation(), PoseNumbers(rng)}),
        Eigen::MatrixXd::Random(6, 15), Eigen::VectorXd::Random(6));
    testing::ExpectFactorConsistent(
        prior, {rotation(), testing::RandomVector(rng, 5.0), rotation(), PoseNumbers(rng)});
  }
}

TEST(LinearPrior, RejectsSizesThatDoNotFit) {
  const std::vector<BlockKind> kinds{Rotation::kKind};
  const Eigen::Vector4d q(0.0, 0.0, 0.0, 1.0);
  const Eigen::MatrixXd R = Eigen::Matrix3d::Identity();
  const Eigen::VectorXd d = Eigen::Vector3d::Zero();
  EXPECT_NO_THROW(LinearPrior(kinds, q, R, d));
  EXPECT_THROW(LinearPrior(kinds, d, R, d), InvalidInput);
  EXPECT_THROW(LinearPrior(kinds, q, Eigen::Matrix4d::Identity(), q), InvalidInput);
  EXPECT_THROW(LinearPrior(kinds, q, R, q), InvalidInput);
  EXPECT_THROW(LinearPrior(kinds, q, Eigen::MatrixXd(0, 3), Eigen::VectorXd()), InvalidInput);
  EXPECT_THROW(LinearPrior(kinds, q, std::nan("") * R, d), InvalidInput);
}

}  // namespace dn::core_test
