#include <dn/error.h>
#include <dn/factors/prior.h>
#include <dn/rotation.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "testing/factor_consistency.h"

namespace dn::factors_test {

using testing::RandomRotation;
using testing::RandomVector;
using testing::State;

template <class F>
Eigen::Vector3d Residual(const F& f, const Eigen::Quaterniond& q) {
  Eigen::Vector3d r;
  EXPECT_TRUE(f.Residual(q.coeffs().data(), r.data()));
  return r;
}

TEST(PriorVector, ResidualIsTheDifferenceInSigmas) {
  const PriorVector<3> f({1.0, 2.0, 3.0}, Noise<3>::Sigma({0.1, 0.2, 0.5}));
  const Eigen::Vector3d x(1.1, 1.8, 4.0);
  Eigen::Vector3d r;
  ASSERT_TRUE(f.Residual(x.data(), r.data()));
  EXPECT_LE((r - Eigen::Vector3d(1.0, -1.0, 2.0)).norm(), 1e-14);
}

template <int N>
void ExpectVectorConsistent(std::mt19937& rng) {
  const Eigen::Matrix<double, N, N> A =
      Eigen::Matrix<double, N, N>::Identity() + 0.1 * Eigen::Matrix<double, N, N>::Ones();
  const PriorVector<N> f(RandomVector<N>(rng, 10.0),
                         Noise<N>::Covariance(Eigen::Matrix<double, N, N>(A * A.transpose())));
  testing::ExpectFactorConsistent(f, {State(RandomVector<N>(rng, 10.0))}, testing::Autodiff(f));
}

TEST(PriorVector, JacobiansAgreeInEverySize) {
  std::mt19937 rng(1);
  for (int i = 0; i < 10; ++i) {
    ExpectVectorConsistent<1>(rng);
    ExpectVectorConsistent<2>(rng);
    ExpectVectorConsistent<3>(rng);
    ExpectVectorConsistent<6>(rng);
  }
}

// Hand calculation: q0 is a yaw of 90 deg. A further rotation of 0.2 rad about the rotated x axis
// is a rotation about x before q0 and about y after it.
TEST(PriorRotation, ResidualIsInTheFrameOnItsSide) {
  const Eigen::Quaterniond q0(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()));
  const Eigen::Quaterniond q = q0 * Exp(Eigen::Vector3d(0.2, 0.0, 0.0));
  const Noise<3> noise = Noise<3>::Sigma({0.1, 0.1, 0.1});
  EXPECT_LE((Residual(PriorRotation(q0, noise), q) - Eigen::Vector3d(2, 0, 0)).norm(), 1e-14);
  EXPECT_LE((Residual(PriorLeftRotation(q0, noise), q) - Eigen::Vector3d(0, 2, 0)).norm(), 1e-14);
}

TEST(PriorRotation, JacobiansAgreeAtRandomStates) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 rng(seed);
    const Eigen::Quaterniond q0 = RandomRotation(rng);
    // Less than half a turn, where the logarithm is discontinuous.
    const Eigen::Vector3d phi = RandomVector(rng, 1.6);
    const Noise<3> noise = Noise<3>::Sigma({0.01, 0.02, 0.05});
    const PriorRotation right(q0, noise);
    testing::ExpectFactorConsistent(right, {State(q0 * Exp(phi))}, testing::Autodiff(right));
    const PriorLeftRotation left(q0, noise);
    testing::ExpectFactorConsistent(left, {State(Exp(phi) * q0)}, testing::Autodiff(left));
  }
}

TEST(PriorRotation, JacobiansAgreeAtSpecialStates) {
  const Eigen::Quaterniond half_turn(0.0, 0.6, 0.0, 0.8);
  const Noise<3> noise = Noise<3>::Sigma(0.1);
  for (const Eigen::Quaterniond& q0 : {Eigen::Quaterniond::Identity(), half_turn}) {
    for (const double angle_rad : {0.0, 1e-9, 1e-4, 3.0}) {
      SCOPED_TRACE(angle_rad);
      const Eigen::Quaterniond turn = Exp(Eigen::Vector3d(angle_rad, 0.0, 0.0));
      const PriorRotation right(q0, noise);
      testing::ExpectFactorConsistent(right, {State(q0 * turn)}, testing::Autodiff(right));
      const PriorLeftRotation left(q0, noise);
      testing::ExpectFactorConsistent(left, {State(turn * q0)}, testing::Autodiff(left));
    }
  }
}

// A common rotation of mean and value on the unmeasured side does not change the residual. The sign
// of a quaternion does not matter either.
TEST(PriorRotation, IsInvariantOnTheOtherSide) {
  std::mt19937 rng(5);
  const Eigen::Quaterniond q0 = RandomRotation(rng), q = q0 * Exp(RandomVector(rng, 0.5));
  const Eigen::Quaterniond turn = RandomRotation(rng);
  const Noise<3> noise = Noise<3>::Sigma({0.01, 0.02, 0.05});
  constexpr double kTolerance = 1e-12;
  const Eigen::Vector3d right = Residual(PriorRotation(q0, noise), q);
  EXPECT_LE((Residual(PriorRotation(turn * q0, noise), turn * q) - right).norm(), kTolerance);
  const Eigen::Vector3d left = Residual(PriorLeftRotation(q0, noise), q);
  EXPECT_LE((Residual(PriorLeftRotation(q0 * turn, noise), q * turn) - left).norm(), kTolerance);
  const Eigen::Quaterniond minus_q(Eigen::Vector4d(-q.coeffs()));
  EXPECT_LE((Residual(PriorRotation(q0, noise), minus_q) - right).norm(), kTolerance);
}

TEST(Prior, RejectsBadInput) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Noise<3> noise = Noise<3>::Sigma(0.1);
  EXPECT_THROW(PriorVector<3>({nan, 0, 0}, noise), InvalidInput);
  EXPECT_THROW(PriorRotation(Eigen::Quaterniond(nan, 0, 0, 0), noise), InvalidInput);
  EXPECT_THROW(PriorRotation(Eigen::Quaterniond(0, 0, 0, 0), noise), InvalidInput);
  EXPECT_THROW(PriorLeftRotation(Eigen::Quaterniond(nan, 0, 0, 0), noise), InvalidInput);
  EXPECT_THROW(PriorLeftRotation(Eigen::Quaterniond(0, 0, 0, 0), noise), InvalidInput);
}

}  // namespace dn::factors_test
