#include <dn/block.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "testing/random.h"

namespace dn::core_test {

// Rounding of a few quaternion products.
constexpr double kManifoldTolerance = 1e-14;
// Near pi, Log is still accurate, but rounding of w decides the sign of the vector.
constexpr double kManifoldStep = 1e-6;
// Central differences with step 1e-6: truncation 1e-12, rounding 1e-10.
constexpr double kManifoldDifferenceTolerance = 1e-9;

class Manifold : public ::testing::TestWithParam<BlockKind> {
 protected:
  bool IsRotation() const { return GetParam().parametrisation != Parametrisation::kVector; }

  Eigen::VectorXd RandomPoint(std::mt19937& rng) const {
    if (IsRotation()) return testing::RandomRotation(rng).coeffs();
    return testing::RandomVector<5>(rng, 100.0);
  }

  Eigen::VectorXd RandomTangent(std::mt19937& rng, double norm) const {
    const Eigen::VectorXd d = testing::RandomVector<5>(rng, 1.0);
    return norm * d.head(GetParam().tangent_size).normalized();
  }

  Eigen::VectorXd Plus(const Eigen::VectorXd& x, const Eigen::VectorXd& d) const {
    Eigen::VectorXd y(x.size());
    dn::Plus(GetParam(), x.data(), d.data(), y.data());
    return y;
  }

  Eigen::VectorXd Minus(const Eigen::VectorXd& y, const Eigen::VectorXd& x) const {
    Eigen::VectorXd d(GetParam().tangent_size);
    dn::Minus(GetParam(), y.data(), x.data(), d.data());
    return d;
  }

  /// Returns the distance between two elements; a quaternion and its negative are the same element.
  double Distance(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const {
    return IsRotation() ? std::min((a - b).norm(), (a + b).norm()) : (a - b).norm();
  }

  template <class Check>
  void ForPointsAndSteps(const Check& check) const {
    for (unsigned seed = 0; seed < 50; ++seed) {
      for (const double norm : {0.0, 1e-12, 1e-5, 1e-4, 1e-3, 0.3, 2.0, 3.14, M_PI - 1e-9}) {
        SCOPED_TRACE("seed " + std::to_string(seed) + ", step " + std::to_string(norm));
        std::mt19937 rng(seed);
        const Eigen::VectorXd x = RandomPoint(rng);
        check(x, RandomTangent(rng, norm));
      }
    }
  }
};

TEST_P(Manifold, PlusOfZeroChangesNothing) {
  ForPointsAndSteps([&](const Eigen::VectorXd& x, const Eigen::VectorXd& d) {
    EXPECT_LE((Plus(x, 0.0 * d) - x).norm(), kManifoldTolerance);
    EXPECT_LE(Minus(x, x).norm(), kManifoldTolerance);
  });
}

TEST_P(Manifold, MinusUndoesPlus) {
  ForPointsAndSteps([&](const Eigen::VectorXd& x, const Eigen::VectorXd& d) {
    EXPECT_LE((Minus(Plus(x, d), x) - d).norm(), kManifoldTolerance * (1.0 + x.norm()));
  });
}

TEST_P(Manifold, PlusUndoesMinus) {
  ForPointsAndSteps([&](const Eigen::VectorXd& x, const Eigen::VectorXd& d) {
    std::mt19937 rng(static_cast<unsigned>(1e6 * std::abs(d.sum())));
    const Eigen::VectorXd y = RandomPoint(rng);
    EXPECT_LE(Distance(Plus(x, Minus(y, x)), y), kManifoldTolerance * (1.0 + y.norm()));
  });
}

TEST_P(Manifold, PlusStaysOnTheManifold) {
  ForPointsAndSteps([&](const Eigen::VectorXd& x, const Eigen::VectorXd& d) {
    const Eigen::VectorXd drifted = IsRotation() ? Eigen::VectorXd(1.001 * x) : x;
    EXPECT_TRUE(!IsRotation() || std::abs(Plus(drifted, d).norm() - 1.0) <= kManifoldTolerance);
    EXPECT_LE((Plus(drifted, d) - Plus(x, d)).norm(), kManifoldTolerance * (1.0 + x.norm()));
  });
}

TEST_P(Manifold, PlusMayOverwriteItsArgument) {
  ForPointsAndSteps([&](const Eigen::VectorXd& x, const Eigen::VectorXd& d) {
    Eigen::VectorXd y = x;
    dn::Plus(GetParam(), y.data(), d.data(), y.data());
    EXPECT_EQ(y, Plus(x, d));
  });
}

TEST_P(Manifold, JacobianIsTheDerivativeOfPlus) {
  ForPointsAndSteps([&](const Eigen::VectorXd& x, const Eigen::VectorXd&) {
    const Eigen::MatrixXd J = PlusJacobian(GetParam(), x.data());
    ASSERT_EQ(J.rows(), GetParam().stored_size);
    ASSERT_EQ(J.cols(), GetParam().tangent_size);
    for (int k = 0; k < J.cols(); ++k) {
      const Eigen::VectorXd d = kManifoldStep * Eigen::VectorXd::Unit(J.cols(), k);
      const Eigen::VectorXd difference = (Plus(x, d) - Plus(x, -d)) / (2.0 * kManifoldStep);
      EXPECT_LE((difference - J.col(k)).norm(), kManifoldDifferenceTolerance * (1.0 + x.norm()));
    }
  });
}

std::string KindName(const ::testing::TestParamInfo<BlockKind>& param_info) {
  const std::vector<std::string> names{"Vector", "RotationRight", "RotationLeft"};
  return names[static_cast<std::size_t>(param_info.param.parametrisation)];
}

INSTANTIATE_TEST_SUITE_P(AllKinds, Manifold,
                         ::testing::Values(Rotation::kKind, LeftRotation::kKind, Vec<5>::kKind),
                         KindName);

// Steps are full angles: a step of 90 degrees about z rotates x into y, whichever side it is
// applied from.
TEST(ManifoldSides, StepsAreFullAnglesInTheirFrames) {
  const Eigen::Vector3d step(0.0, 0.0, M_PI / 2);
  const Eigen::Quaterniond q(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX()));
  Eigen::Quaterniond right, left;
  Plus(Rotation::kKind, q.coeffs().data(), step.data(), right.coeffs().data());
  Plus(LeftRotation::kKind, q.coeffs().data(), step.data(), left.coeffs().data());
  // Right: the step rotates x to y about its own z first, then q rotates y to z.
  EXPECT_LE((right * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitZ()).norm(),
            kManifoldTolerance);
  // Left: q keeps x, then the step rotates x to y.
  EXPECT_LE((left * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(),
            kManifoldTolerance);
}

}  // namespace dn::core_test
