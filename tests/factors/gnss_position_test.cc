#include <dn/error.h>
#include <dn/factors/gnss_position.h>
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

Eigen::Vector3d Residual(const GnssPosition& f, const Eigen::Quaterniond& q_mb,
                         const Eigen::Vector3d& p_mb, const Eigen::Vector3d& a_b) {
  Eigen::Vector3d r;
  EXPECT_TRUE(f.Residual(q_mb.coeffs().data(), p_mb.data(), a_b.data(), r.data()));
  return r;
}

// Hand calculation: a yaw of +90 deg rotates body x to map y.
TEST(GnssPosition, ResidualOfAQuarterTurn) {
  const GnssPosition f({10.0, 22.0, 30.0}, Noise<3>::Sigma(0.5));
  const Eigen::Quaterniond q_mb(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()));
  const Eigen::Vector3d r = Residual(f, q_mb, {10.0, 20.0, 30.0}, {1.0, 0.0, 0.0});
  EXPECT_LE((r - Eigen::Vector3d(0.0, -2.0, 0.0)).norm(), 1e-14);  // (21 - 22) / 0.5
}

TEST(GnssPosition, JacobiansAgreeAtRandomStates) {
  Eigen::Matrix3d covariance;
  covariance << 4e-4, 1e-4, 0, 1e-4, 9e-4, -2e-4, 0, -2e-4, 25e-4;
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 rng(seed);
    const GnssPosition f(RandomVector(rng, 1e3), Noise<3>::Covariance(covariance));
    testing::ExpectFactorConsistent(
        f,
        {State(RandomRotation(rng)), State(RandomVector(rng, 1e3)), State(RandomVector(rng, 2.0))},
        testing::Autodiff(f));
  }
}

TEST(GnssPosition, JacobiansAgreeAtSpecialStates) {
  const GnssPosition f({1.0, 2.0, 3.0}, Noise<3>::Sigma({0.02, 0.02, 0.05}));
  const Eigen::VectorXd p_mb = Eigen::Vector3d(4.0, 5.0, 6.0);
  const Eigen::Quaterniond half_turn(0.0, 0.6, 0.0, 0.8);
  for (const Eigen::Quaterniond& q_mb : {Eigen::Quaterniond::Identity(), half_turn}) {
    for (const Eigen::Vector3d& a_b : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 0, -1)}) {
      testing::ExpectFactorConsistent(f, {State(q_mb), p_mb, State(a_b)}, testing::Autodiff(f));
    }
  }
}

// Rotating and shifting the whole map only rotates the residual if the noise is isotropic.
TEST(GnssPosition, DoesNotDependOnTheMap) {
  std::mt19937 rng(3);
  const Eigen::Quaterniond q_nm = RandomRotation(rng), q_mb = RandomRotation(rng);
  const Eigen::Vector3d p_nm = RandomVector(rng, 1e3), p_mb = RandomVector(rng, 1e3);
  const Eigen::Vector3d z_m = p_mb + RandomVector(rng, 3.0), a_b = RandomVector(rng, 2.0);
  const Noise<3> noise = Noise<3>::Sigma(0.1);
  const Eigen::Vector3d r_m = Residual(GnssPosition(z_m, noise), q_mb, p_mb, a_b);
  const Eigen::Vector3d r_n =
      Residual(GnssPosition(q_nm * z_m + p_nm, noise), q_nm * q_mb, q_nm * p_mb + p_nm, a_b);
  EXPECT_LE((r_n - q_nm * r_m).norm(), 1e-10);
}

TEST(GnssPosition, RejectsBadInput) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_THROW(GnssPosition({nan, 0, 0}, Noise<3>::Sigma(0.1)), InvalidInput);
  EXPECT_THROW(GnssPosition({0, inf, 0}, Noise<3>::Sigma(0.1)), InvalidInput);
}

}  // namespace dn::factors_test
